// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include <ros/time.h>

namespace lidar_mapping::ros_border {

/// Limits repeated warnings to one in 5 s for each subject, by the wall clock, because the
/// simulated time of roscpp's own throttle may stand still. One thread calls it.
class WarningLimiter {
 public:
  /// A subject is first reported when it has lasted for `patience`.
  explicit WarningLimiter(ros::WallDuration patience = ros::WallDuration(0.0))
      : patience_(patience) {}

  /// True if the subject may be reported now.
  bool due(const std::string& subject);

 private:
  ros::WallDuration patience_;
  std::map<std::string, ros::WallTime> silent_until_;
};

}  // namespace lidar_mapping::ros_border
