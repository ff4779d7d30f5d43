// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/ros/chunked_recording.hpp"

namespace lidar_mapping::ros_border {

class FileBytes;

/// A bag of version 2.0 (wiki.ros.org/Bags/Format/2.0), or some topics of it, chunk by chunk.
/// Unlike rosbag it leaves messages where they were decompressed, and checks each length, offset
/// and count against the data, so that damaged bags are safe to read. Throws FileError with the
/// position in the file and the remedy.
class BagFile : public ChunkedRecording {
 public:
  /// Reads the index of these topics; topics that do not exist are ignored.
  explicit BagFile(const std::string& path, const WantedTopics& topics = std::nullopt);
  ~BagFile() override;

  /// Path that was given to the constructor.
  const std::string& path() const { return path_; }
  const std::map<std::uint32_t, BagConnection>& connections() const override {
    return connections_;
  }
  const std::vector<BagChunk>& chunks() const override { return chunks_; }
  std::vector<BagEntry> entries(const BagChunk& chunk) override;
  ChunkContent read(const BagChunk& chunk, ChunkMemory& memory) override;
  /// The data stay in the content.
  StoredMessage message(const ChunkContent& content, const BagEntry& entry) const override;

  /// Throws FileError with the path, the reason and the remedy.
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  struct Record;

  [[noreturn]] void fail_at(std::uint64_t position) const;
  [[noreturn]] void fail_chunk(std::uint64_t position) const;

  Record record_at(std::uint64_t position) const;
  void read_index(const WantedTopics& topics);
  std::uint64_t index_position(const Record& header) const;
  void add_connection(const Record& record, const WantedTopics& topics);
  void add_chunk(const Record& record);
  void add_entries(const Record& record, std::vector<BagEntry>& entries) const;

  std::string path_;
  std::unique_ptr<const FileBytes> file_;
  std::map<std::uint32_t, BagConnection> connections_;
  std::vector<BagChunk> chunks_;
  std::vector<std::uint8_t> compressed_;
};

}  // namespace lidar_mapping::ros_border
