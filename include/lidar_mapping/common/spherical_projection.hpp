// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "lidar_mapping/common/fast_angle.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping {

/// A pixel of an image of all directions.
struct SphericalPixel {
  int row = 0;     ///< from straight down (0) to straight up
  int column = 0;  ///< from behind (0) over the right, ahead and the left to behind again
};

/// The pixel of a direction in an image whose rows divide half a turn and whose columns divide a
/// turn evenly (equirectangular projection). `ray`: from the sensor to a point, of any length and
/// unit; x ahead, y to the left, z up.
inline SphericalPixel spherical_pixel(const Eigen::Vector3f& ray, int rows, int columns) {
  const float elevation = fast_angle(ray.z(), ray.head<2>().norm());
  const float azimuth = fast_angle(ray.y(), ray.x());
  const auto row = static_cast<int>((elevation / kPiFloat + 0.5F) * static_cast<float>(rows));
  const auto column =
      static_cast<int>((azimuth / kPiFloat + 1.0F) * 0.5F * static_cast<float>(columns));
  return {std::clamp(row, 0, rows - 1), std::clamp(column, 0, columns - 1)};
}

}  // namespace lidar_mapping
