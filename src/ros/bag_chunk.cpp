#include "bag_chunk.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include <bzlib.h>
#include <lz4.h>

#include "lidar_mapping/common/errors.hpp"

#include "xxh32.hpp"

namespace lidar_mapping::ros_border {

namespace {

// Of the LZ4 frame format (lz4_Frame_format.md), as far as rosbag uses it.
constexpr std::uint32_t kMagic = 0x184D2204;
constexpr std::uint32_t kNotCompressed = 0x80000000;
constexpr std::uint8_t kVersionMask = 0xC0, kVersion = 0x40;
constexpr std::uint8_t kIndependent = 0x20;
constexpr std::uint8_t kBlockChecksum = 0x10;
constexpr std::uint8_t kContentSize = 0x08;
constexpr std::uint8_t kContentChecksum = 0x04;
constexpr std::uint8_t kDictionary = 0x01;
constexpr std::size_t kMostToLz4 = std::numeric_limits<int>::max();
constexpr std::size_t kDescriptor = 3;  // flags, block size, checksum of the header

[[noreturn]] void fail() { throw InputError("a chunk is damaged"); }

class Reader {
 public:
  explicit Reader(ByteRange data) : data_(data) {}

  const std::uint8_t* take(std::size_t size) {
    if (size > data_.size) fail();
    const std::uint8_t* const first = data_.first;
    data_ = {first + size, data_.size - size};
    return first;
  }
  std::uint32_t take_number() {
    std::uint32_t number = 0;
    std::memcpy(&number, take(sizeof number), sizeof number);
    return number;
  }

 private:
  ByteRange data_;
};

/// Returns the flags. The header's checksum is the second byte of that of all before it.
std::uint8_t read_frame_header(Reader& reader) {
  if (reader.take_number() != kMagic) fail();
  const std::uint8_t* const descriptor = reader.take(kDescriptor);
  const std::uint32_t checksum = xxh32({descriptor, kDescriptor - 1});
  if (descriptor[kDescriptor - 1] != static_cast<std::uint8_t>(checksum >> 8U)) fail();
  const std::uint8_t flags = descriptor[0];
  const std::uint8_t unknown = kContentSize | kDictionary;
  if ((flags & kVersionMask) != kVersion || (flags & kIndependent) == 0 || (flags & unknown) != 0) {
    fail();
  }
  return flags;
}

void decompress_lz4(ByteRange data, std::uint8_t* to, std::size_t size) {
  const ByteRange content{to, size};
  Reader reader(data);
  const std::uint8_t flags = read_frame_header(reader);
  while (const std::uint32_t block = reader.take_number()) {
    const std::size_t length = block & ~kNotCompressed;
    const std::uint8_t* const from = reader.take(length);
    std::size_t written = length;
    if ((block & kNotCompressed) == 0) {
      const int result = LZ4_decompress_safe(reinterpret_cast<const char*>(from),
                                             reinterpret_cast<char*>(to), static_cast<int>(length),
                                             static_cast<int>(std::min(size, kMostToLz4)));
      if (result < 0) fail();
      written = static_cast<std::size_t>(result);
    } else {
      if (length > size) fail();
      std::memcpy(to, from, length);
    }
    to += written;
    size -= written;
    if ((flags & kBlockChecksum) != 0 && reader.take_number() != xxh32({from, length})) fail();
  }
  if (size != 0) fail();
  if ((flags & kContentChecksum) != 0 && reader.take_number() != xxh32(content)) fail();
}

void decompress_bz2(ByteRange data, std::uint8_t* to, std::size_t size) {
  auto length = static_cast<unsigned>(size);
  // The library takes its input as char*, but leaves it as it is.
  auto* const from = const_cast<char*>(reinterpret_cast<const char*>(data.first));
  const int result = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(to), &length, from,
                                                static_cast<unsigned>(data.size), 0, 0);
  if (result != BZ_OK || length != size) fail();
}

}  // namespace

void decompress(const std::string& compression, ByteRange data, std::uint8_t* to,
                std::size_t size) {
  if (compression == "lz4") return decompress_lz4(data, to, size);
  if (compression == "bz2") return decompress_bz2(data, to, size);
  throw InputError("its compression " + compression + " is unknown");
}

std::size_t largest_content(const std::string& compression, std::size_t bytes) {
  // A byte of lz4 stands for at most 255; the shortest block of bzip2 (some 37 bytes) for 900 kB.
  constexpr std::size_t kLz4 = 255, kBzip2 = 25'000;
  if (compression == "lz4") return kLz4 * bytes;
  if (compression == "bz2") return kBzip2 * bytes;
  return bytes;
}

}  // namespace lidar_mapping::ros_border
