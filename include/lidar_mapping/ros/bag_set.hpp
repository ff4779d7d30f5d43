// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/bag_stream.hpp"

namespace lidar_mapping::ros_border {

/// What is recorded of one topic with one type of message.
struct BagTopic {
  std::string name;            ///< as recorded
  std::string type;            ///< package/Name
  std::uint64_t messages = 0;  ///< as the index says
};

/// The bags of one drive, by their indexes. Nothing stays open. Throws FileError, which says what
/// to do, where there is no such file, where it is no bag, where the recording was broken off and
/// where its index is damaged.
class BagSet {
 public:
  /// Reads the indexes of these files.
  explicit BagSet(std::vector<std::string> paths);

  /// As they were given to the constructor.
  const std::vector<std::string>& paths() const { return paths_; }
  /// What is recorded, each topic and type once, in the order of their names and types.
  const std::vector<BagTopic>& topics() const { return topics_; }
  /// The topic is recorded with one of the types.
  bool has(const std::string& topic, const std::vector<std::string>& types) const;
  /// When the first and the last message of the topics were recorded; nothing if there is none.
  /// What is damaged is passed over.
  std::optional<std::pair<Stamp, Stamp>> times_of(const std::vector<std::string>& topics) const;
  /// The messages of the topics, in the order of their times.
  BagStream messages_of(const std::vector<std::string>& topics) const { return {paths_, topics}; }

 private:
  std::vector<std::string> paths_;
  std::vector<BagTopic> topics_;
};

}  // namespace lidar_mapping::ros_border
