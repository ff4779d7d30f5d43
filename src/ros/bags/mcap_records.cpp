// SPDX-License-Identifier: BSD-3-Clause
#include "bags/mcap_records.hpp"

#include <limits>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

// The elements of a list in braces are evaluated in their order, so that a record whose members
// stand in the order of the format is read as one.

/// By the format, lists and maps have their length in bytes before them.
McapReader list_of(McapReader& reader) { return McapReader(reader.bytes(reader.u32())); }

}  // namespace

Stamp McapReader::time() {
  const std::uint64_t time = u64();
  if (time / kNanosecondsPerSecond > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError("a time does not fit into a time of ROS");
  }
  return static_cast<Stamp>(time);
}

std::string McapReader::text() {
  const ByteRange from = bytes(u32());
  return {reinterpret_cast<const char*>(from.first), from.size};
}

ByteRange McapReader::bytes(std::uint64_t size) {
  if (size > left()) throw InputError("a record is shorter than it says");
  const ByteRange range{bytes_.first + at_, static_cast<std::size_t>(size)};
  at_ += range.size;
  return range;
}

McapSchema mcap_schema(ByteRange content) {
  McapReader reader(content);
  return {reader.u16(), reader.text()};
}

McapChannel mcap_channel(ByteRange content) {
  McapReader reader(content);
  return {reader.u16(), reader.u16(), reader.text(), reader.text()};
}

McapChunkHead mcap_chunk_head(McapReader& reader) {
  for (int i = 0; i < 2; ++i) reader.time();  // of the first and the last message
  return {reader.u64(), reader.u32(), reader.text(), reader.u64()};
}

McapMessageIndex mcap_message_index(ByteRange content) {
  McapReader reader(content);
  McapMessageIndex index{reader.u16(), {}};
  McapReader list = list_of(reader);
  while (list.left() > 0) index.entries.push_back({list.time(), list.u64()});
  return index;
}

McapChunkIndex mcap_chunk_index(ByteRange content) {
  McapReader reader(content);
  McapChunkIndex index;
  index.begin = reader.time();
  reader.time();  // of the last message
  index.position = reader.u64();
  index.length = reader.u64();
  McapReader channels = list_of(reader);
  while (channels.left() > 0) {
    index.channels.push_back(channels.u16());
    channels.u64();  // the position of its message index, which is among those behind the chunk
  }
  index.index_length = reader.u64();
  return index;
}

McapStatistics mcap_statistics(ByteRange content) {
  McapReader reader(content);
  McapStatistics statistics;
  statistics.messages = reader.u64();
  reader.u16();                              // schemas
  for (int i = 0; i < 3; ++i) reader.u32();  // channels, attachments, metadata
  statistics.chunks = reader.u32();
  reader.bytes(8 + 8);  // times of the first and the last message
  McapReader counts = list_of(reader);
  while (counts.left() > 0) {
    const std::uint16_t channel = counts.u16();
    statistics.messages_of[channel] = counts.u64();
  }
  return statistics;
}

McapRecord next_mcap_record(McapReader& reader) {
  McapRecord record;
  record.position = reader.position();
  record.kind = *reader.bytes(1).first;
  record.content = reader.bytes(reader.u64());
  return record;
}

}  // namespace lidar_mapping::ros_border
