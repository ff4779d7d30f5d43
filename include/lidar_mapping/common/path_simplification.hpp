// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping {

/// Positions in a path (m) of the points without which its shape would suffer most, in order
/// (Douglas and Peucker 1973): at most `limit` (at least 2) of them, the first and the last among
/// them. All points of a path that has no more.
std::vector<std::size_t> simplified_path(const std::vector<Eigen::Vector3d>& path,
                                         std::size_t limit);

}  // namespace lidar_mapping
