// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/byte_range.hpp"
#include "lidar_mapping/ros/chunk_memory.hpp"

namespace lidar_mapping::ros_border {

/// Names of the topics that are read of a recording; none: all are read.
using WantedTopics = std::optional<std::vector<std::string>>;

/// Whether the topic is one of these.
bool is_wanted(const std::string& topic, const WantedTopics& wanted);

/// Connection of a bag, or channel of an MCAP file: the messages of one publisher on a topic.
struct BagConnection {
  std::string topic;           ///< name, as recorded
  std::string type;            ///< package/Name; empty if unknown
  std::string md5sum;          ///< of the type
  std::uint64_t messages = 0;  ///< number of messages by the index
};

/// Chunk of a recording, the unit of reading.
struct BagChunk {
  std::uint64_t position = 0;  ///< of its record, bytes from the beginning of the file
  Stamp begin = 0;             ///< when its first message was recorded
};

/// Earlier, or of the same time and before it in the file.
inline bool operator<(const BagChunk& a, const BagChunk& b) {
  return std::tie(a.begin, a.position) < std::tie(b.begin, b.position);
}

/// A message of a chunk.
struct BagEntry {
  Stamp recorded = 0;            ///< when it was recorded
  std::uint32_t offset = 0;      ///< into the chunk's content, bytes
  std::uint32_t connection = 0;  ///< key in ChunkedRecording::connections()
};

/// Earlier, or of the same time and before it in the chunk.
inline bool operator<(const BagEntry& a, const BagEntry& b) {
  return std::tie(a.recorded, a.offset) < std::tie(b.recorded, b.offset);
}

/// Decompressed content of a chunk; the memory is reused after the last pointer to it is gone.
struct ChunkContent {
  std::shared_ptr<std::uint8_t> bytes;  ///< decompressed
  std::size_t size = 0;                 ///< number of bytes
};

/// Serialised data of a message as ROS 1 has it, and the memory in which they lie.
struct StoredMessage {
  ByteRange data;                      ///< serialised
  std::shared_ptr<const void> memory;  ///< keeps the data
};

/// A damage because of which only a part of a recording is read.
struct MissingPart {
  Stamp from = 0;      ///< when the last message before it was recorded
  std::string reason;  ///< with file, place and remedy
};

/// A recording that is read chunk by chunk: a bag, or an MCAP file. Throws FileError with the
/// position in the file and the remedy.
class ChunkedRecording {
 public:
  ChunkedRecording() = default;
  virtual ~ChunkedRecording() = default;
  ChunkedRecording(const ChunkedRecording&) = delete;
  ChunkedRecording& operator=(const ChunkedRecording&) = delete;

  /// Connections of the wanted topics, by the numbers that the recording gives them.
  const std::map<std::uint32_t, BagConnection>& connections() const { return connections_; }
  /// Chunks that hold messages of the topics, in the order of their beginnings.
  const std::vector<BagChunk>& chunks() const { return chunks_; }
  /// Messages of the topics, in the order of their times and then of the file.
  virtual std::vector<BagEntry> entries(const BagChunk& chunk) = 0;
  /// The content of a chunk, decompressed into `memory`. One thread calls it at a time.
  virtual ChunkContent read(const BagChunk& chunk, ChunkMemory& memory) = 0;
  /// The message in the content.
  virtual StoredMessage message(const ChunkContent& content, const BagEntry& entry) const = 0;
  /// What is missing of the file; empty if it is whole.
  virtual std::optional<MissingPart> missing_part() const { return std::nullopt; }

 protected:
  std::map<std::uint32_t, BagConnection> connections_;  ///< see connections(); a file fills it
  std::vector<BagChunk> chunks_;                        ///< see chunks(); a file fills it
};

/// Opens a bag or an MCAP file with these topics; topics that do not exist are ignored.
std::unique_ptr<ChunkedRecording> open_chunked(const std::string& path,
                                               const WantedTopics& topics = std::nullopt);

}  // namespace lidar_mapping::ros_border
