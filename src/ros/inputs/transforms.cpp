// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/transforms.hpp"

#include <ros/console.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

namespace lidar_mapping::ros_border {

std::optional<Pose> SensorFrames::lookup(const std::string& target, const std::string& source) {
  const std::string to = frame_name(target);
  const std::string from = frame_name(source);
  if (to == from) return Pose::Identity();
  const auto known = found_.find({to, from});
  if (known != found_.end()) return known->second;
  const std::optional<Pose> pose = ask(to, from);
  if (pose) found_[{to, from}] = *pose;
  return pose;
}

Pose SensorFrames::required(const std::string& target, const std::string& source) {
  if (const std::optional<Pose> pose = lookup(target, source)) return *pose;
  throw InputError("no transform from '" + source + "' to '" + target + "'");
}

std::optional<Eigen::Vector3d> SensorFrames::origin_of(const std::string& sensor_frame,
                                                       const std::string& base_frame) {
  if (sensor_frame.empty()) return std::nullopt;
  const std::optional<Pose> T_base_sensor = lookup(base_frame, sensor_frame);
  if (!T_base_sensor) return std::nullopt;
  return T_base_sensor->translation;
}

std::optional<Pose> SensorFrames::ask(const std::string& target, const std::string& source) {
  try {
    return from_message(buffer_.lookupTransform(target, source, ros::Time(0)).transform);
  } catch (const std::exception& error) {
    if (limiter_.due(target + " " + source)) {
      ROS_WARN_STREAM("no transform from frame '"
                      << source << "' to '" << target
                      << "' yet: publish it on /tf_static, or correct the "
                         "frame names ("
                      << error.what() << ")");
    }
    return std::nullopt;
  }
}

std::optional<GnssPosition> gnss_position(const nav_msgs::Odometry& message,
                                          const std::string& base_frame, SensorFrames& frames) {
  const std::optional<Pose> T_base_antenna = frames.lookup(base_frame, message.child_frame_id);
  if (!T_base_antenna) return std::nullopt;
  return from_message(message, T_base_antenna->translation);
}

}  // namespace lidar_mapping::ros_border
