// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/mesh.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// Adds a trunk, boughs and a crown of loose leaves.
void add_tree(TriangleMesh& mesh, const Eigen::Vector3d& foot, double height, Random random);
/// Adds a bush of leaves that reaches from the ground to `height`.
void add_bush(TriangleMesh& mesh, const Eigen::Vector3d& foot, double height, Random random);
/// Adds a lamp post whose arm points along `yaw`.
void add_lamp(TriangleMesh& mesh, const Eigen::Vector3d& foot, double yaw, Random random);
/// Adds a post with a plate that faces `yaw`.
void add_sign(TriangleMesh& mesh, const Eigen::Vector3d& foot, double yaw, Random random);
/// Adds a fence, wall or hedge from `a` to `b`.
void add_fence(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
               Random random);
/// Adds a waste bin, letter box, switch box or bollard.
void add_street_box(TriangleMesh& mesh, const Eigen::Vector3d& foot, double yaw, Random random);

}  // namespace lidar_mapping::simulation
