// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidar_mapping::ros_border {

/// Edge of the voxels (m) with which a map of that many Gaussians is displayed: 0.5 m, and larger
/// by powers of two where the points would be more than rviz shows fluently.
inline double display_resolution(std::size_t gaussians) {
  constexpr double kSmallest = 0.5;         // m; chosen: a town of 1 km then has some 10 MB
  constexpr double kMostPoints = 4e6;       // chosen: 64 MB
  constexpr double kPointsPerGaussian = 6;  // measured in a town, with voxels of 0.5 m
  double edge = kSmallest;
  double points = kPointsPerGaussian * static_cast<double>(gaussians);
  for (; points > kMostPoints; points /= 4.0) edge *= 2.0;  // surfaces: by the square of the edge
  return edge;
}

}  // namespace lidar_mapping::ros_border
