// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/ros/byte_range.hpp"

#include "bags/message_layout.hpp"

namespace lidar_mapping::ros_border {

/// A message of ROS 2, serialised as CDR (OMG Common Data Representation, version 1, little-endian,
/// in which numbers are aligned to their size), in the serialisation of ROS 1. Throws InputError
/// for another representation, and for a message that is shorter than it says.
std::vector<std::uint8_t> from_cdr(ByteRange message, const MessageLayout& layout);

}  // namespace lidar_mapping::ros_border
