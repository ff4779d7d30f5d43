// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <ros/serialization.h>

#include "lidar_mapping/ros/byte_range.hpp"

namespace lidar_mapping::ros_border {

/// Reads the number of elements of an array, each of at least `size` bytes. Throws ros::Exception
/// if the data end before so many. The library allocates their number before it checks that, so
/// that a damaged one could exhaust the memory.
inline std::uint32_t array_length(ros::serialization::IStream& stream, std::uint32_t size) {
  std::uint32_t length = 0;
  stream.next(length);
  if (length > stream.getLength() / size) ros::serialization::throwStreamOverrun();
  return length;
}

/// The bytes of an array whose elements have `size` bytes; they stay where they are. Throws
/// ros::Exception if they are cut off.
inline ByteRange array_bytes(ros::serialization::IStream& stream, std::uint32_t size = 1) {
  const std::uint32_t bytes = array_length(stream, size) * size;
  return {stream.advance(bytes), bytes};
}

}  // namespace lidar_mapping::ros_border
