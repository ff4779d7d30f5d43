// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/ros/chunked_recording.hpp"

namespace lidar_mapping::ros_border {

class FileBytes;
struct McapIndex;
struct McapPlace;
struct Ros2Type;

/// A recording of ROS 2 in MCAP (mcap.dev/spec), or some topics of it, with chunks that are
/// uncompressed or compressed by LZ4 or Zstandard. Chunks are found by the summary at the end of
/// the file; where that is missing or damaged, or does not know them, the file is read from the
/// front. Types of message that are alike in ROS 1 are converted, so that nothing of ROS 2 is
/// needed; of others only the names are known. Each length, offset and count is checked against the
/// data. Throws FileError with the position in the file and the remedy.
class McapFile : public ChunkedRecording {
 public:
  /// Whether the file begins as such a file does.
  static bool is_one(const std::string& path);

  /// Reads the index of these topics; topics that do not exist are ignored.
  explicit McapFile(const std::string& path, const WantedTopics& topics = std::nullopt);
  ~McapFile() override;

  /// With the types' names and MD5 sums of ROS 1; the sum is empty for types that are not read.
  const std::map<std::uint32_t, BagConnection>& connections() const override {
    return connections_;
  }
  const std::vector<BagChunk>& chunks() const override { return chunks_; }
  std::vector<BagEntry> entries(const BagChunk& chunk) override;
  ChunkContent read(const BagChunk& chunk, ChunkMemory& memory) override;
  StoredMessage message(const ChunkContent& content, const BagEntry& entry) const override;
  std::optional<MissingPart> missing_part() const override { return missing_; }

 private:
  void add_connections(const McapIndex& index, const WantedTopics& topics);
  void add_places(const McapIndex& index);
  std::vector<BagEntry> indexed_entries(const McapPlace& place) const;
  std::vector<BagEntry> entries_of(const ChunkContent& content, const McapPlace& place) const;

  std::string path_;
  std::unique_ptr<const FileBytes> file_;
  std::map<std::uint32_t, BagConnection> connections_;
  std::map<std::uint32_t, const Ros2Type*> types_;  ///< those that are read, by channel
  std::vector<BagChunk> chunks_;
  std::map<std::uint64_t, std::shared_ptr<const McapPlace>> places_;  ///< by their positions
  std::optional<MissingPart> missing_;
  ChunkMemory memory_;  ///< of chunks without message indexes
};

}  // namespace lidar_mapping::ros_border
