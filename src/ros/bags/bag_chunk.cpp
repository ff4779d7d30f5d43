// SPDX-License-Identifier: BSD-3-Clause
#include "bags/bag_chunk.hpp"

#include <memory>
#include <new>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

[[noreturn]] void fail() { throw InputError("a chunk is damaged"); }

/// The library compares the checksums of header, blocks and content.
void decompress_lz4(ByteRange data, std::uint8_t* to, std::size_t size) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, LZ4F_freeDecompressionContext);
  std::size_t wanted = 1;
  while (wanted != 0) {
    std::size_t read = data.size;
    std::size_t written = size;
    wanted = LZ4F_decompress(context.get(), to, &written, data.first, &read, nullptr);
    if (LZ4F_isError(wanted) != 0) fail();
    if (wanted != 0 && read == 0 && written == 0) fail();  // cut off, or longer than it says
    data = {data.first + read, data.size - read};
    to += written;
    size -= written;
  }
  if (size != 0) fail();
}

void decompress_bz2(ByteRange data, std::uint8_t* to, std::size_t size) {
  auto length = static_cast<unsigned>(size);
  // The library takes its input as char*, but leaves it as it is.
  auto* const from = const_cast<char*>(reinterpret_cast<const char*>(data.first));
  const int result = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(to), &length, from,
                                                static_cast<unsigned>(data.size), 0, 0);
  if (result != BZ_OK || length != size) fail();
}

/// The library compares the checksum of the content, if there is one.
void decompress_zstd(ByteRange data, std::uint8_t* to, std::size_t size) {
  const std::size_t length = ZSTD_decompress(to, size, data.first, data.size);
  if (ZSTD_isError(length) != 0 || length != size) fail();
}

}  // namespace

void decompress(const std::string& compression, ByteRange data, std::uint8_t* to,
                std::size_t size) {
  if (compression == "lz4") return decompress_lz4(data, to, size);
  if (compression == "bz2") return decompress_bz2(data, to, size);
  if (compression == "zstd") return decompress_zstd(data, to, size);
  throw InputError("its compression " + compression + " is unknown");
}

std::size_t largest_content(const std::string& compression, std::size_t bytes) {
  // By the formats, a byte of lz4 stands for at most 255; the shortest block of bzip2 (some 37
  // bytes) for 900 kB, and that of Zstandard (4 bytes) for 128 KiB.
  constexpr std::size_t kLz4 = 255, kBzip2 = 25'000, kZstandard = 32'768;
  if (compression == "lz4") return kLz4 * bytes;
  if (compression == "bz2") return kBzip2 * bytes;
  if (compression == "zstd") return kZstandard * bytes;
  return bytes;
}

}  // namespace lidar_mapping::ros_border
