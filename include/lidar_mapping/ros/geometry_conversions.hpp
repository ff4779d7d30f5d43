// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <boost/array.hpp>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Quaternion.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/Vector3.h>
#include <ros/time.h>
#include <std_msgs/Header.h>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::ros_border {

/// Covariance of a message: 6x6 row-major, x y z roll pitch yaw.
using CovarianceArray = boost::array<double, 36>;

/// Stamps cross the border bit for bit, in integers. Throws InputError where ros::Time cannot hold
/// the stamp (before 1970 or after 2106).
ros::Time to_ros(Stamp stamp);
/// The stamp of a time of ROS, bit for bit.
Stamp from_ros(const ros::Time& time);
/// The header of a message with this stamp and frame.
std_msgs::Header header_of(Stamp stamp, const std::string& frame_id);

/// The quaternion, of length 1. One that has it but for rounding stays as it is, bit for bit: to
/// divide it by its length once more would change its last digits with every message that it
/// travels in.
Eigen::Quaterniond unit(const Eigen::Quaterniond& rotation);

/// A rotation, bit for bit.
geometry_msgs::Quaternion to_quaternion(const Eigen::Quaterniond& rotation);
/// Position (m) and orientation.
geometry_msgs::Pose to_message(const Pose& pose);
/// Translation (m) and rotation: T_a_b is the transform from a (header) to b (child).
geometry_msgs::Transform to_transform(const Pose& pose);
/// The pose of frame `child` in frame `parent` at a stamp, as tf takes it.
geometry_msgs::TransformStamped stamped_transform(const Pose& T_parent_child, Stamp stamp,
                                                  const std::string& parent,
                                                  const std::string& child);
/// The pose in a message. Throws InputError for values that are not finite or a quaternion whose
/// length is more than 0.01 away from 1.
Pose from_message(const geometry_msgs::Pose& pose);
/// The pose in a transform, with the same errors.
Pose from_message(const geometry_msgs::Transform& transform);
/// The pose in either message; none where from_message() throws.
template <typename Message>
std::optional<Pose> valid_pose(const Message& message) try {
  return from_message(message);
} catch (const InputError&) {
  return std::nullopt;
}

/// Three numbers of any unit.
geometry_msgs::Vector3 to_message(const Eigen::Vector3d& vector);
/// Three numbers of any unit, unchecked.
Eigen::Vector3d from_message(const geometry_msgs::Vector3& vector);
/// A twist: linear (m/s), then angular (rad/s).
geometry_msgs::Twist to_twist(const Vector6d& twist);
/// The other way round.
Vector6d from_message(const geometry_msgs::Twist& twist);

/// The covariance as a message has it, made exactly symmetric.
CovarianceArray to_array(const Covariance6& covariance);
/// The covariance in a message, unchecked.
Covariance6 from_array(const CovarianceArray& values);

/// The frame's name without the leading slash of tf 1, which tf2 refuses.
std::string frame_name(const std::string& frame_id);

}  // namespace lidar_mapping::ros_border
