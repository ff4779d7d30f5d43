// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/ros/chunked_recording.hpp"

#include "bags/message_layout.hpp"

namespace lidar_mapping::ros_border {

/// A type of message of ROS 2 that has the same fields in ROS 1.
struct Ros2Type {
  std::string ros1_name;  ///< package/Name
  std::string md5sum;     ///< of ROS 1
  MessageLayout layout;   ///< of both
};

/// The type of this name ("sensor_msgs/msg/Imu"), or null if it is not read.
const Ros2Type* ros2_type(const std::string& name);

/// The connection that a topic with messages of this type is in ROS 1; it has no MD5 sum if they
/// are not read.
BagConnection ros2_connection(const std::string& topic, const std::string& type);

/// "sensor_msgs/Imu" for "sensor_msgs/msg/Imu"; other names stay as they are.
std::string name_in_ros1(const std::string& name);

}  // namespace lidar_mapping::ros_border
