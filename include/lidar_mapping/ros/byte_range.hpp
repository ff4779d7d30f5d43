// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidar_mapping::ros_border {

/// Bytes in memory that is owned elsewhere.
struct ByteRange {
  const std::uint8_t* first = nullptr;  ///< null only if there are no bytes
  std::size_t size = 0;                 ///< number of bytes
};

}  // namespace lidar_mapping::ros_border
