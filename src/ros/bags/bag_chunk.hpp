// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "lidar_mapping/ros/byte_range.hpp"

namespace lidar_mapping::ros_border {

/// Fills `size` bytes at `to` with the content of a chunk that was compressed by "lz4", "bz2" or
/// "zstd". Throws InputError for damaged data, also if only the checksum shows the damage.
void decompress(const std::string& compression, ByteRange data, std::uint8_t* to, std::size_t size);

/// Largest decompressed size of a number of bytes, against which the size in a damaged bag is
/// checked.
std::size_t largest_content(const std::string& compression, std::size_t bytes);

}  // namespace lidar_mapping::ros_border
