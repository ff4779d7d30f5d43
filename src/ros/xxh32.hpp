#pragma once

#include <cstdint>

#include "lidar_mapping/ros/byte_range.hpp"

namespace lidar_mapping::ros_border {

/// XXH32 with seed 0, the checksum of LZ4's frames (Y. Collet, xxHash fast digest algorithm,
/// xxhash_spec.md; on little-endian machines).
std::uint32_t xxh32(ByteRange data);

}  // namespace lidar_mapping::ros_border
