// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>

namespace lidar_mapping::preprocessing {

/// Points in the layout of a driver: x y z adjacent as floats, and a float intensity. They are not
/// read before they are deskewed, so that each point is accessed only once.
struct PackedPoints {
  std::shared_ptr<const void> memory;    ///< owner of the memory
  const unsigned char* first = nullptr;  ///< x of the first point
  std::size_t step = 0;                  ///< bytes from point to point, 16 or more
  std::size_t intensity = 0;             ///< bytes from x to the intensity
};

}  // namespace lidar_mapping::preprocessing
