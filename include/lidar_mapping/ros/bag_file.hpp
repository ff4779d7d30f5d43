// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/byte_range.hpp"
#include "lidar_mapping/ros/chunk_memory.hpp"

namespace lidar_mapping::ros_border {

/// Connection of a bag: the messages of one publisher on a topic.
struct BagConnection {
  std::string topic;           ///< name, as recorded
  std::string type;            ///< package/Name; empty if unknown
  std::string md5sum;          ///< of the type
  std::uint64_t messages = 0;  ///< number of messages by the index
};

/// Chunk of a bag, the unit of reading.
struct BagChunk {
  std::uint64_t position = 0;  ///< of its record, bytes from the beginning of the file
  Stamp begin = 0;             ///< when its first message was recorded
};

/// A message of a chunk.
struct BagEntry {
  Stamp recorded = 0;            ///< when it was recorded
  std::uint32_t offset = 0;      ///< into the chunk's content, bytes
  std::uint32_t connection = 0;  ///< key in BagFile::connections()
};

/// Decompressed content of a chunk; the memory is reused after the last pointer to it is gone.
struct ChunkContent {
  std::shared_ptr<std::uint8_t> bytes;  ///< decompressed
  std::size_t size = 0;                 ///< number of bytes
};

/// A bag of version 2.0 (wiki.ros.org/Bags/Format/2.0), or some topics of it, chunk by chunk.
/// Unlike rosbag it leaves messages where they were decompressed, and checks each length, offset
/// and count against the data, so that damaged bags are safe to read. Throws FileError with the
/// position in the file and the remedy.
class BagFile {
 public:
  /// Reads the index of all topics.
  explicit BagFile(const std::string& path);
  /// Reads the index of some topics; topics that do not exist are ignored.
  BagFile(const std::string& path, const std::vector<std::string>& topics);
  ~BagFile();
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  /// Path that was given to the constructor.
  const std::string& path() const { return path_; }
  /// Connections of the topics, by the numbers that the bag gives them.
  const std::map<std::uint32_t, BagConnection>& connections() const { return connections_; }
  /// Chunks that hold messages of the topics, in the order of their beginnings.
  const std::vector<BagChunk>& chunks() const { return chunks_; }
  /// Messages of the topics, in the order of their times and then of the file.
  std::vector<BagEntry> entries(const BagChunk& chunk) const;
  /// The content of a chunk, decompressed into `memory`. One thread calls it at a time.
  ChunkContent read(const BagChunk& chunk, ChunkMemory& memory);
  /// Serialised data of the message in the content.
  ByteRange message(const ChunkContent& content, const BagEntry& entry) const;

  /// Throws FileError with the path, the reason and the remedy.
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  struct Record;

  BagFile(const std::string& path, const std::vector<std::string>* topics);

  [[noreturn]] void fail_at(std::uint64_t position) const;
  [[noreturn]] void fail_chunk(std::uint64_t position) const;

  Record record_at(std::uint64_t position) const;
  void read_bytes(std::uint64_t position, void* to, std::size_t size) const;
  void read_index(const std::vector<std::string>* topics);
  std::uint64_t index_position(const Record& header) const;
  void add_connection(const Record& record, const std::vector<std::string>* topics);
  void add_chunk(const Record& record);
  void add_entries(const Record& record, std::vector<BagEntry>& entries) const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::map<std::uint32_t, BagConnection> connections_;
  std::vector<BagChunk> chunks_;
  std::vector<std::uint8_t> compressed_;
};

}  // namespace lidar_mapping::ros_border
