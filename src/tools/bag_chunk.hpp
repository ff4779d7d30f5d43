#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace lidar_mapping::tools {

/// Bytes that somebody else keeps.
struct ByteRange {
  const std::uint8_t* first = nullptr;
  std::size_t size = 0;
};

/// Fills `size` bytes at `to` with the content of a chunk that was compressed by "lz4" or "bz2". Of
/// lz4 the checksum is not looked at, which would take as long as the rest (check_bag
/// looks). Throws InputError for damaged data.
void decompress(const std::string& compression, ByteRange data, std::uint8_t* to, std::size_t size);

/// What so many bytes can hold at most; damaged bags claim anything.
std::size_t largest_content(const std::string& compression, std::size_t bytes);

}  // namespace lidar_mapping::tools
