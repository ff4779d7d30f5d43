// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "lidar_mapping/ros/silent_topic.hpp"

namespace lidar_mapping::ros_border {

/// Input of an optional sensor, with the types of message that it is read from.
struct OptionalInput {
  std::string name;                ///< also that of the launch file's argument
  std::string topic;               ///< resolved
  std::vector<std::string> types;  ///< package/Name
};

/// Finds sensors that are published on another topic than the subscribed one. Any thread may call
/// it.
class OverlookedSensors {
 public:
  /// `inputs`: the subscribed ones; `own`: topics that this package publishes, resolved.
  OverlookedSensors(std::vector<OptionalInput> inputs, std::set<std::string> own);

  /// Records that a message of this input was received.
  void mark_received(const std::string& input);
  /// Returns a line with the candidates for each input without messages and publisher for which
  /// topics of its types are published. Each input is reported once.
  std::map<std::string, std::string> search(const ros::master::V_TopicInfo& published);
  /// Whether all inputs were received or reported.
  bool is_complete() const;

 private:
  mutable std::mutex mutex_;
  std::vector<OptionalInput> inputs_;  ///< neither received nor reported
  std::set<std::string> own_;
};

}  // namespace lidar_mapping::ros_border
