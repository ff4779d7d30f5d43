// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <mutex>
#include <string>

#include <ros/wall_timer.h>

#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/overlooked_sensors.hpp"

namespace lidar_mapping::ros_border {

/// Observes the inputs of preprocessing_node in the first minute. It warns with the reason while no
/// scans arrive, and after that of other sensors that are published on topics that the node does
/// not subscribe.
class InputWatch {
 public:
  /// Starts the checks. `context` outlives this object.
  explicit InputWatch(NodeContext& context);

  /// Records that a scan was received. Any thread may call it.
  void mark_scan() { has_scans_ = true; }
  /// Records that a message of an optional input was received. Any thread may call it.
  void mark_received(const std::string& input) { overlooked_.mark_received(input); }
  /// Warns at once of a reason for missing scans, which then stands for what the topics say. Any
  /// thread may call it.
  void explain(const std::string& reason);

 private:
  void check_inputs();
  void warn_without_scans();
  void warn_of(const std::string& reason);
  void warn_of_overlooked_sensors();

  NodeContext& context_;
  OverlookedSensors overlooked_;
  std::atomic<bool> has_scans_{false};
  std::atomic<bool> is_explained_{false};  ///< why there are no scans
  std::mutex mutex_;
  std::string last_reason_;  ///< reason for missing scans that was logged last; guarded by mutex_
  int searches_ = 0;
  Worker search_worker_;  ///< queries the ROS master, which may be slow
  Worker::ChannelId searching_;
  ros::WallTimer timer_;
};

}  // namespace lidar_mapping::ros_border
