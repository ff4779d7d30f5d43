// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::simulation {

/// Share of light that a surface sends back, 0 to 255, as a calibrated LiDAR reports it.
using Reflectivity = std::uint8_t;

/// Triangles with a reflectivity each.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Reflectivity> reflectivity;
};

void add_triangle(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c, Reflectivity reflectivity);
/// Corners in order around the quadrilateral.
void add_quad(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
              const Eigen::Vector3d& c, const Eigen::Vector3d& d, Reflectivity reflectivity);
/// A box of `size` around the origin of `T_mesh_box`.
void add_box(TriangleMesh& mesh, const Pose& T_mesh_box, const Eigen::Vector3d& size,
             Reflectivity reflectivity);
/// A prism of `sides` faces from `foot` to `foot + axis`, open at its ends.
void add_tube(TriangleMesh& mesh, const Eigen::Vector3d& foot, const Eigen::Vector3d& axis,
              double foot_radius, double top_radius, int sides, Reflectivity reflectivity);
/// Appends `other`, moved by T_mesh_other.
void append(TriangleMesh& mesh, const TriangleMesh& other, const Pose& T_mesh_other = {});

}  // namespace lidar_mapping::simulation
