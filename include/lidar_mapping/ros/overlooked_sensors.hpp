// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "lidar_mapping/ros/silent_topic.hpp"

namespace lidar_mapping::ros_border {

/// A sensor that may be there or not: its input, with the types of message that it is read from.
struct OptionalInput {
  std::string name;                ///< of the launch file's argument, too
  std::string topic;               ///< resolved
  std::vector<std::string> types;  ///< package/Name
};

/// Finds out that a sensor is published under another name than the one that is listened to. Any
/// thread may call it.
class OverlookedSensors {
 public:
  /// `inputs`: those that are listened to; `own`: topics that this package publishes, resolved.
  OverlookedSensors(std::vector<OptionalInput> inputs, std::set<std::string> own);

  /// A message of that input has come.
  void heard(const std::string& input);
  /// For each input of which nothing has come, that nobody publishes, and for which topics of its
  /// types are published: a line that names them. Each input once.
  std::map<std::string, std::string> look(const std::vector<PublishedTopic>& published);
  /// Nothing is left to look for.
  bool done() const;

 private:
  mutable std::mutex mutex_;
  std::vector<OptionalInput> inputs_;  ///< not heard, not spoken of
  std::set<std::string> own_;
};

}  // namespace lidar_mapping::ros_border
