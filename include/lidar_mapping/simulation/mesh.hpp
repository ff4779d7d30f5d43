// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::simulation {

/// Fraction of light that a surface reflects, scaled to 0 to 255 as a calibrated LiDAR reports it.
using Reflectivity = std::uint8_t;

/// A mesh of triangles, each with a reflectivity.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;                ///< Corners, m.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Three indices into `vertices` each.
  std::vector<Reflectivity> reflectivity;               ///< One per triangle.
};

/// Adds a triangle with these corners, m.
void add_triangle(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c, Reflectivity reflectivity);
/// Adds a quadrilateral as two triangles; the corners are in order around it.
void add_quad(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
              const Eigen::Vector3d& c, const Eigen::Vector3d& d, Reflectivity reflectivity);
/// Adds a box of `size` (m) around the origin of `T_mesh_box`.
void add_box(TriangleMesh& mesh, const Pose& T_mesh_box, const Eigen::Vector3d& size,
             Reflectivity reflectivity);
/// Adds a box along the axes between two corners.
void add_block(TriangleMesh& mesh, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
               Reflectivity reflectivity);
/// Adds a prism of `sides` faces from `foot` to `foot + axis`, open at its ends; radii in m.
void add_tube(TriangleMesh& mesh, const Eigen::Vector3d& foot, const Eigen::Vector3d& axis,
              double foot_radius, double top_radius, int sides, Reflectivity reflectivity);
/// Appends the triangles of `other`, transformed by T_mesh_other.
void append(TriangleMesh& mesh, const TriangleMesh& other, const Pose& T_mesh_other);

}  // namespace lidar_mapping::simulation
