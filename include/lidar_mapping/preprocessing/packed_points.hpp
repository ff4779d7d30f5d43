// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::preprocessing {

/// Points as a driver wrote them: x y z side by side as floats, a float intensity. Nobody reads
/// them before they are moved, so that each is touched once.
struct PackedPoints {
  std::shared_ptr<const void> memory;    ///< what keeps them
  const unsigned char* first = nullptr;  ///< x of the first point
  std::size_t step = 0;                  ///< bytes from point to point, 16 or more
  std::size_t intensity = 0;             ///< bytes from x to the intensity
};

/// Reads as many points as there is room for in the cloud.
void read_points(const PackedPoints& packed, PointCloud& cloud);

}  // namespace lidar_mapping::preprocessing
