// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "lidar_mapping/simulation/mesh.hpp"

#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// Adds the terrain between two corners as a grid of cells of `cell` metres.
void add_ground(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, double cell, Reflectivity reflectivity);

/// Adds a pavement: the terrain within a quadrilateral, raised by `height` (m), with a vertical
/// kerb around it.
void add_pavement(TriangleMesh& mesh, const Terrain& terrain,
                  const std::array<Eigen::Vector2d, 4>& corners, double height);
/// Pose of an object that stands on the terrain at `at`, tilted with it, with x along `yaw`.
Pose on_slope(const Terrain& terrain, const Eigen::Vector2d& at, double yaw);

}  // namespace lidar_mapping::simulation
