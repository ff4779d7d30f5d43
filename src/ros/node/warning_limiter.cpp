// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/warning_limiter.hpp"

namespace lidar_mapping::ros_border {

namespace {
const ros::WallDuration kInterval(5.0);
}

bool WarningLimiter::due(const std::string& subject) {
  const ros::WallTime now = ros::WallTime::now();
  ros::WallTime& until = silent_until_.try_emplace(subject, now + patience_).first->second;
  if (now < until) return false;
  until = now + kInterval;
  return true;
}

}  // namespace lidar_mapping::ros_border
