#include "lidar_mapping/ros/warning_limiter.hpp"

namespace lidar_mapping::ros_border {

namespace {
const ros::WallDuration kInterval(5.0);
}

bool WarningLimiter::due(const std::string& subject) {
  const ros::WallTime now = ros::WallTime::now();
  const auto [entry, is_new] = spoken_at_.try_emplace(subject, now);
  if (!is_new && now - entry->second < kInterval) return false;
  entry->second = now;
  return true;
}

}  // namespace lidar_mapping::ros_border
