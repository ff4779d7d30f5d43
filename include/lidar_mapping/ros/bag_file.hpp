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

/// What is sent on a topic by one publisher.
struct BagConnection {
  std::string topic;
  std::string type;
  std::string md5sum;  ///< of the type
  std::uint64_t messages = 0;
};

/// A part of a bag that is read as a whole.
struct BagChunk {
  std::uint64_t position = 0;
  Stamp begin = 0;  ///< of its first message
};

/// A message of a chunk.
struct BagEntry {
  Stamp recorded = 0;
  std::uint32_t offset = 0;  ///< into the chunk's content
  std::uint32_t connection = 0;
};

/// The content of a chunk: a view of memory that comes back when nobody holds it.
struct ChunkContent {
  std::shared_ptr<std::uint8_t> bytes;
  std::size_t size = 0;
};

/// A bag of version 2.0 (wiki.ros.org/Bags/Format/2.0), or some topics of it, chunk by chunk. What
/// rosbag does not offer is to leave messages where they were decompressed, and to believe no
/// length, offset or count of a damaged bag: here each is held against what is there. Throws
/// FileError with the position in the file and what to do.
class BagFile {
 public:
  explicit BagFile(const std::string& path);
  BagFile(const std::string& path, const std::vector<std::string>& topics);
  ~BagFile();
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  const std::string& path() const { return path_; }
  /// Those of the topics.
  const std::map<std::uint32_t, BagConnection>& connections() const { return connections_; }
  /// Those that hold messages of the topics, in the order of their beginnings.
  const std::vector<BagChunk>& chunks() const { return chunks_; }
  /// Messages of the topics, in the order of their times and then of the file.
  std::vector<BagEntry> entries(const BagChunk& chunk) const;
  ChunkContent read(const BagChunk& chunk, ChunkMemory& memory);
  /// Where the message lies in the content.
  ByteRange message(const ChunkContent& content, const BagEntry& entry) const;

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
