// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include <zlib.h>

#include "lidar_mapping/common/errors.hpp"

#include "bags/bag_chunk.hpp"
#include "bags/mcap_index.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Bytes in which the head of a chunk ends. Chosen: the names of compressions are short.
constexpr std::uint64_t kLongestHead = 200;

ChunkContent run_of_records(const FileBytes& file, const McapSpan& span, ChunkMemory& memory) {
  ChunkContent content;
  content.size = span.end - span.position;
  content.bytes = memory.take(content.size);
  file.read(span.position, content.bytes.get(), content.size);
  return content;
}

void check_sizes(const McapChunkHead& head, std::uint64_t left) {
  if (head.compressed_size > left) throw InputError("a chunk is damaged");
  const std::uint64_t largest = largest_content(head.compression, head.compressed_size);
  // Offsets into the content have 32 bits.
  if (head.size > std::min<std::uint64_t>(largest, std::numeric_limits<std::uint32_t>::max())) {
    throw InputError("a chunk is damaged");
  }
}

void fill(const FileBytes& file, const McapChunkHead& head, std::uint64_t position,
          const ChunkContent& content, ChunkMemory& memory) {
  if (head.compression.empty()) {
    if (head.size != head.compressed_size) throw InputError("a chunk is damaged");
    return file.read(position, content.bytes.get(), content.size);
  }
  const std::shared_ptr<std::uint8_t> compressed = memory.take(head.compressed_size);
  file.read(position, compressed.get(), head.compressed_size);
  decompress(head.compression, {compressed.get(), head.compressed_size}, content.bytes.get(),
             content.size);
}

void check_crc(const McapChunkHead& head, const ChunkContent& content) {
  if (head.crc == 0) return;
  if (::crc32_z(0, content.bytes.get(), content.size) != head.crc) {
    throw InputError("a chunk is damaged (its checksum differs)");
  }
}

ChunkContent chunk(const FileBytes& file, const McapSpan& span, ChunkMemory& memory) {
  const std::uint64_t begin = span.position + kMcapHead;
  const std::vector<std::uint8_t> front =
      file.read(begin, std::min(kLongestHead, span.end - begin));
  McapReader reader({front.data(), front.size()});
  const McapChunkHead head = mcap_chunk_head(reader);
  const std::uint64_t records = begin + reader.position();
  check_sizes(head, span.end - records);
  ChunkContent content;
  content.size = head.size;
  content.bytes = memory.take(content.size);
  fill(file, head, records, content, memory);
  check_crc(head, content);
  return content;
}

}  // namespace

ChunkContent mcap_content(const FileBytes& file, const McapSpan& span, ChunkMemory& memory) try {
  return span.is_run ? run_of_records(file, span, memory) : chunk(file, span, memory);
} catch (const InputError& error) {
  file.fail(error.what(), span.position);
}

}  // namespace lidar_mapping::ros_border
