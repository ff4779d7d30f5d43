// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/bag_stream.hpp"

namespace lidar_mapping::ros_border {

/// The recorded messages of one topic and type.
struct BagTopic {
  std::string name;            ///< as recorded
  std::string type;            ///< package/Name, of what BagStream gives of it
  std::uint64_t messages = 0;  ///< number by the index
  std::string md5sum;          ///< of the type, in the first bag that has the topic
};

/// The bags of one drive, or recordings of ROS 2 (MCAP, SQLite), by their indexes. No file stays
/// open. Throws FileError with the remedy if a file does not exist, is no bag, was not closed by
/// the recording or has a damaged index.
class BagSet {
 public:
  /// Reads the indexes of these files.
  explicit BagSet(std::vector<std::string> paths);

  /// Paths that were given to the constructor.
  const std::vector<std::string>& paths() const { return paths_; }
  /// Recorded topics, each topic and type once, sorted by name and type.
  const std::vector<BagTopic>& topics() const { return topics_; }
  /// Whether the topic is recorded with one of the types.
  bool has(const std::string& topic, const std::vector<std::string>& types) const;
  /// Times of recording of the first and the last message of the topics; empty if there is none.
  /// Damaged parts are ignored.
  std::optional<std::pair<Stamp, Stamp>> times_of(const std::vector<std::string>& topics) const;
  /// The messages of the topics, in the order of their times.
  BagStream messages_of(const std::vector<std::string>& topics) const { return {paths_, topics}; }

 private:
  std::vector<std::string> paths_;
  std::vector<BagTopic> topics_;
};

}  // namespace lidar_mapping::ros_border
