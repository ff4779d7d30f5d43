// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/chunked_recording.hpp"
#include "lidar_mapping/ros/ros2_file.hpp"

namespace lidar_mapping::ros_border {

class OusterTopics;

/// A serialised message of a bag. It stays where it was decompressed for as long as `memory` lives.
/// Two functions have the names of those of rosbag::MessageInstance, because templates read both.
struct BagMessage {
  const BagConnection* connection = nullptr;  ///< lives as long as the stream
  Stamp recorded = 0;                         ///< when it was recorded
  ByteRange data;                             ///< serialised
  std::shared_ptr<const void> memory;         ///< where the data lie

  /// Its topic, as recorded.
  const std::string& topic() const { return connection->topic; }
  /// Its type: package/Name.
  const std::string& getDataType() const { return connection->type; }
  /// Whether the message is of this type, by the MD5 sum.
  template <typename Message>
  bool is() const {
    return connection->md5sum == ros::message_traits::MD5Sum<Message>::value();
  }
  /// The message; empty if it is of another type. Throws ros::Exception if it is damaged. Not for
  /// types with arrays of variable length, because the library does not check their length before
  /// it allocates memory: see read_cloud() and read_transforms().
  template <typename Message>
  std::optional<Message> instantiate() const {
    if (!is<Message>()) return std::nullopt;
    std::optional<Message> message(std::in_place);
    ros::serialization::IStream from = stream_of(data);
    ros::serialization::deserialize(from, *message);
    return message;
  }
};

/// Damaged parts of bags.
struct BagDamage {
  std::size_t places = 0;  ///< number of damaged chunks and messages
  Stamp first = 0;         ///< when the first of them was recorded
  std::string reason;      ///< of the first
};

/// Messages of several bags, or recordings of ROS 2 (MCAP files, SQLite), in the order of their
/// times, equal ones in that of the bags and files.
/// Packets of an Ouster become clouds and IMU samples (see OusterTopics).
/// A chunk is decompressed once, and only chunks with messages that are due soon are kept, so that
/// memory does not grow with the recording. Throws FileError if a bag cannot be read at all; chunks
/// and messages that are damaged are left out.
class BagStream {
 public:
  /// What is given of packets of sensors that need several messages for a scan.
  enum class Packets {
    kAsMessages,  ///< what they hold: clouds, IMU samples
    kAsTheyAre    ///< themselves
  };

  /// The messages of these topics in the bags.
  BagStream(const std::vector<std::string>& paths, const std::vector<std::string>& topics,
            Packets packets = Packets::kAsMessages);

  /// The next message; nothing at the end.
  std::optional<BagMessage> next();
  /// Damage that was found so far; damaged parts are left out.
  const BagDamage& damage() const { return damage_; }
  /// Number of packets of an Ouster so far that came when their turn had been given out; they are
  /// left out.
  std::size_t late_packets() const;
  /// Skips to the first message that was recorded at or after `stamp`.
  void skip_to(Stamp stamp);

 private:
  struct Bag {
    std::unique_ptr<ChunkedRecording> file;
    std::size_t next_chunk = 0;
  };
  /// Time, bag and chunk of the next message of an open chunk; sorts the open chunks.
  using ChunkPosition = std::tuple<Stamp, std::size_t, std::uint64_t>;
  struct OpenChunk {
    BagChunk chunk;
    std::vector<BagEntry> entries;
    std::size_t next = 0;
    std::optional<ChunkContent> content;
  };
  using OpenChunks = std::map<ChunkPosition, OpenChunk>;
  /// A recording of ROS 2; null after its end, or where reading it failed.
  using Ros2Recording = std::unique_ptr<Ros2File>;

  void open(const std::vector<std::string>& paths, const std::vector<std::string>& topics);
  std::vector<std::string> topics_of(const std::string& type) const;
  std::optional<BagMessage> next_recorded();
  std::optional<BagMessage> made_of(const BagMessage& message);
  /// The chunk with the earliest message, or the end.
  OpenChunks::iterator earliest();
  void open_next_chunk(std::size_t bag);
  std::optional<BagMessage> message_at(OpenChunks::iterator at);
  void add_damage(Stamp stamp, const FileError& error);
  void advance(OpenChunks::iterator at);
  const ChunkContent& content(OpenChunks::iterator at);
  void evict_farthest();
  /// The recording of ROS 2 with the earliest message, and its time; null if there is none.
  std::pair<Ros2Recording*, Stamp> earliest_of_ros2();
  std::optional<BagMessage> take_from(Ros2Recording& recording);

  std::shared_ptr<OusterTopics> ousters_;  ///< null if there are none
  std::vector<Bag> bags_;
  std::vector<Ros2Recording> ros2_recordings_;
  std::vector<Ros2Recording> ended_;  ///< their connections may still be in use
  OpenChunks open_;
  BagDamage damage_;
  ChunkMemory memory_;
};

}  // namespace lidar_mapping::ros_border
