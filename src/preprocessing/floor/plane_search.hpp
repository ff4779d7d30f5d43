// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::preprocessing {

/// The plane normal . p + offset = 0; the normal has unit length and points upward.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;

  double distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset; }
};

/// The plane with the most points within `tolerance` (m) among planes through three points whose
/// normal is tilted by at most `largest_lean` (rad) (Fischler and Bolles 1981). The random numbers
/// are seeded, so the same points give the same plane. Empty if no three points give such a plane.
std::optional<Plane> search_plane(const std::vector<Eigen::Vector3d>& points, double tolerance,
                                  double largest_lean);

}  // namespace lidar_mapping::preprocessing
