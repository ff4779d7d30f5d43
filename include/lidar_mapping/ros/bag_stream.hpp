// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
#include "lidar_mapping/ros/bag_file.hpp"

namespace lidar_mapping::ros_border {

/// A message as it was written. It stays where it was decompressed for as long as somebody holds
/// `memory`. Two functions have the names of those of rosbag::MessageInstance, in whose stead it is
/// read.
struct BagMessage {
  const BagConnection* connection = nullptr;  ///< lives as long as the stream
  Stamp recorded = 0;                         ///< when it was recorded
  ByteRange data;                             ///< as it was on the wire
  std::shared_ptr<const void> memory;         ///< where the data lie

  /// Its topic, as recorded.
  const std::string& topic() const { return connection->topic; }
  /// Its type: package/Name.
  const std::string& getDataType() const { return connection->type; }
  /// It is of this type, by the MD5 sum.
  template <typename Message>
  bool holds() const {
    return connection->md5sum == ros::message_traits::MD5Sum<Message>::value();
  }
  /// The message; nothing if it holds another type. Throws ros::Exception if it is damaged. Not for
  /// types with arrays of any length, whose number the library believes: see read_cloud() and
  /// read_transforms().
  template <typename Message>
  std::optional<Message> instantiate() const {
    if (!holds<Message>()) return std::nullopt;
    std::optional<Message> message(std::in_place);
    ros::serialization::IStream from = stream();
    ros::serialization::deserialize(from, *message);
    return message;
  }
  /// The data for roscpp's deserialisation. The library takes its input as uint8_t*, but leaves it
  /// as it is.
  ros::serialization::IStream stream() const {
    return {const_cast<std::uint8_t*>(data.first), static_cast<std::uint32_t>(data.size)};
  }
};

/// What of bags could not be read.
struct BagDamage {
  std::size_t places = 0;  ///< chunks or messages
  Stamp first = 0;         ///< when the first of them was recorded
  std::string reason;      ///< of the first
};

/// Messages of several bags in the order of their times, equal ones in that of the bags and files.
/// A chunk is decompressed once, and nothing is kept but the chunks whose messages are under way:
/// neither time nor memory grows with the recording. Throws FileError if a bag cannot be read at
/// all; chunks and messages that are damaged are left out.
class BagStream {
 public:
  /// The messages of these topics in the bags.
  BagStream(const std::vector<std::string>& paths, const std::vector<std::string>& topics);

  /// The next message; nothing at the end.
  std::optional<BagMessage> next();
  /// What was left out so far.
  const BagDamage& damage() const { return damage_; }
  /// Goes on to the first message that was recorded at or after `stamp`.
  void skip_to(Stamp stamp);

 private:
  struct Bag {
    std::unique_ptr<BagFile> file;
    std::size_t next_chunk = 0;
  };
  /// Time, bag and position of the chunk of a message that is to come.
  using Place = std::tuple<Stamp, std::size_t, std::uint64_t>;
  struct OpenChunk {
    BagChunk chunk;
    std::vector<BagEntry> entries;
    std::size_t next = 0;
    std::optional<ChunkContent> content;
  };
  using OpenChunks = std::map<Place, OpenChunk>;

  /// The chunk with the earliest message, or the end.
  OpenChunks::iterator earliest();
  void open_next_chunk(std::size_t bag);
  std::optional<BagMessage> taken(OpenChunks::iterator at);
  void note(Stamp stamp, const FileError& error);
  void advance(OpenChunks::iterator at);
  const ChunkContent& content(OpenChunks::iterator at);
  void forget_farthest();

  std::vector<Bag> bags_;
  OpenChunks open_;
  BagDamage damage_;
  ChunkMemory memory_;
};

}  // namespace lidar_mapping::ros_border
