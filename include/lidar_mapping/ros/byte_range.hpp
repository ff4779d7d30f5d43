// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include <ros/serialization.h>

namespace lidar_mapping::ros_border {

/// Bytes in memory that is owned elsewhere.
struct ByteRange {
  const std::uint8_t* first = nullptr;  ///< null only if there are no bytes
  std::size_t size = 0;                 ///< number of bytes
};

/// Bytes for roscpp's deserialisation. The library takes its input as uint8_t*, but leaves it as it
/// is.
inline ros::serialization::IStream stream_of(ByteRange bytes) {
  return {const_cast<std::uint8_t*>(bytes.first), static_cast<std::uint32_t>(bytes.size)};
}

}  // namespace lidar_mapping::ros_border
