// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>

#include <nav_msgs/Odometry.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/ros/warning_limiter.hpp"

namespace lidar_mapping::ros_border {

/// Poses of sensors on the vehicle, from tf. Sensors are fixed to the vehicle, so a pose that was
/// found once is kept, also when time jumps back. One thread calls it.
class SensorFrames {
 public:
  /// Pose T_target_source; empty while tf does not have it. Never waits. Warns, naming both frames,
  /// when a pair has been missing for 1 s, and at most once in 5 s. Frames may have tf 1's leading
  /// slash.
  std::optional<Pose> lookup(const std::string& target, const std::string& source);
  /// The same pose. Throws InputError while tf does not have it.
  Pose required(const std::string& target, const std::string& source);
  /// Position of a sensor on the vehicle (m, in base_frame); empty also if its frame is empty.
  std::optional<Eigen::Vector3d> origin_of(const std::string& sensor_frame,
                                           const std::string& base_frame);

 private:
  std::optional<Pose> ask(const std::string& target, const std::string& source);

  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
  std::map<std::pair<std::string, std::string>, Pose> found_;
  WarningLimiter limiter_{
      ros::WallDuration(1.0)};  // /tf_static may arrive shortly after the first scan
};

/// The position of synced_gnss, with the lever arm that tf has for its antenna (child_frame_id);
/// empty while tf does not have it.
std::optional<GnssPosition> gnss_position(const nav_msgs::Odometry& message,
                                          const std::string& base_frame, SensorFrames& frames);

}  // namespace lidar_mapping::ros_border
