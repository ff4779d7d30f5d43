// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/byte_range.hpp"

// The records of an MCAP file, by its specification (mcap.dev/spec). Each begins with its kind and
// its length; numbers are little-endian.
namespace lidar_mapping::ros_border {

/// Kinds of record that are read; others are skipped.
enum class McapKind : std::uint8_t {
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kDataEnd = 15
};

/// Bytes of kind and length before the content of a record.
constexpr std::size_t kMcapHead = 9;  // by the format
/// The same for the head of a message's content: channel, sequence and two times.
constexpr std::size_t kMcapMessageHead = 2 + 4 + 8 + 8;  // by the format

/// Reads the content of a record from the front. Throws InputError behind its end.
class McapReader {
 public:
  /// The bytes stay where they are.
  explicit McapReader(ByteRange bytes) : bytes_(bytes) {}

  std::uint16_t u16() { return number_at<std::uint16_t>(bytes(2).first); }
  std::uint32_t u32() { return number_at<std::uint32_t>(bytes(4).first); }
  std::uint64_t u64() { return number_at<std::uint64_t>(bytes(8).first); }
  /// A time, which has to fit into a time of ROS.
  Stamp time();
  std::string text();
  ByteRange bytes(std::uint64_t size);
  /// Numbers of bytes read, and left.
  std::size_t position() const { return at_; }
  std::size_t left() const { return bytes_.size - at_; }

 private:
  ByteRange bytes_;
  std::size_t at_ = 0;
};

// The members of these five stand in the order of the format.

/// A type of message.
struct McapSchema {
  std::uint16_t id = 0;
  std::string name;  ///< "sensor_msgs/msg/Imu"
};

/// A topic of one publisher.
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;  ///< 0: none
  std::string topic;
  std::string encoding;  ///< of the messages: "cdr"
};

/// What a chunk says of its content, which follows.
struct McapChunkHead {
  std::uint64_t size = 0;  ///< bytes of the content, decompressed
  std::uint32_t crc = 0;   ///< of the decompressed content; 0: unknown
  std::string compression;
  std::uint64_t compressed_size = 0;  ///< bytes that follow
};

/// A message in the content of a chunk.
struct McapEntry {
  Stamp logged = 0;
  std::uint64_t offset = 0;  ///< of its record, bytes
};

/// Messages of one channel in a chunk.
struct McapMessageIndex {
  std::uint16_t channel = 0;
  std::vector<McapEntry> entries;
};

/// Where a chunk is.
struct McapChunkIndex {
  Stamp begin = 0;                 ///< log time of its first message
  std::uint64_t position = 0;      ///< of the chunk's record, bytes
  std::uint64_t length = 0;        ///< of that record with its head, bytes
  std::uint64_t index_length = 0;  ///< of the message indexes behind it, bytes
  std::vector<std::uint16_t> channels;
};

/// How much a file holds.
struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0;
  std::map<std::uint16_t, std::uint64_t> messages_of;  ///< by channel
};

// Each throws InputError if the record is shorter than it says.
McapSchema mcap_schema(ByteRange content);
McapChannel mcap_channel(ByteRange content);
/// `reader` is behind the head afterwards.
McapChunkHead mcap_chunk_head(McapReader& reader);
McapMessageIndex mcap_message_index(ByteRange content);
McapChunkIndex mcap_chunk_index(ByteRange content);
McapStatistics mcap_statistics(ByteRange content);

/// A record in memory.
struct McapRecord {
  std::uint8_t kind = 0;     ///< McapKind, or another
  std::size_t position = 0;  ///< of its head, bytes
  ByteRange content;

  bool is(McapKind other) const { return kind == static_cast<std::uint8_t>(other); }
};

/// The next of several records.
McapRecord next_mcap_record(McapReader& reader);

}  // namespace lidar_mapping::ros_border
