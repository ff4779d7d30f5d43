// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// By how much the length of a quaternion may differ from 1. Chosen: far above rounding to float
/// and to the digits of a file, far below the difference of four numbers that are no rotation.
constexpr double kQuaternionTolerance = 1e-2;

Pose checked(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) {
  const double length = rotation.norm();
  if (!translation.allFinite() || !(std::abs(length - 1.0) < kQuaternionTolerance)) {
    throw InputError("a pose is not finite or its quaternion has length " + std::to_string(length) +
                     " instead of 1");
  }
  return {unit(rotation), translation};
}

Eigen::Matrix<double, 6, 6, Eigen::RowMajor> symmetric(const Covariance6& covariance) {
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

std_msgs::Header header_of(Stamp stamp, const std::string& frame_id) {
  std_msgs::Header header;
  header.stamp = to_ros(stamp);
  header.frame_id = frame_id;
  return header;
}

Eigen::Quaterniond unit(const Eigen::Quaterniond& rotation) {
  constexpr double kRounding = 1e-14;  // of the squared norm; chosen: 45 roundings of 2.2e-16
  if (std::abs(rotation.squaredNorm() - 1.0) < kRounding) return rotation;
  return rotation.normalized();
}

ros::Time to_ros(Stamp stamp) {
  constexpr Stamp kLast =
      (Stamp{std::numeric_limits<std::uint32_t>::max()} + 1) * kNanosecondsPerSecond - 1;
  if (stamp < 0 || stamp > kLast) {
    throw InputError("stamp " + std::to_string(stamp) + " ns does not fit into a ROS time");
  }
  return {static_cast<std::uint32_t>(stamp / kNanosecondsPerSecond),
          static_cast<std::uint32_t>(stamp % kNanosecondsPerSecond)};
}

Stamp from_ros(const ros::Time& time) {
  return Stamp{time.sec} * kNanosecondsPerSecond + Stamp{time.nsec};
}

geometry_msgs::Quaternion to_quaternion(const Eigen::Quaterniond& rotation) {
  geometry_msgs::Quaternion message;
  message.x = rotation.x();
  message.y = rotation.y();
  message.z = rotation.z();
  message.w = rotation.w();
  return message;
}

geometry_msgs::Pose to_message(const Pose& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.translation.x();
  message.position.y = pose.translation.y();
  message.position.z = pose.translation.z();
  message.orientation = to_quaternion(pose.rotation);
  return message;
}

geometry_msgs::Transform to_transform(const Pose& pose) {
  geometry_msgs::Transform message;
  message.translation = to_message(pose.translation);
  message.rotation = to_quaternion(pose.rotation);
  return message;
}

geometry_msgs::TransformStamped stamped_transform(const Pose& T_parent_child, Stamp stamp,
                                                  const std::string& parent,
                                                  const std::string& child) {
  geometry_msgs::TransformStamped message;
  message.header = header_of(stamp, parent);
  message.child_frame_id = child;
  message.transform = to_transform(T_parent_child);
  return message;
}

Pose from_message(const geometry_msgs::Pose& pose) {
  const auto& q = pose.orientation;
  return checked({q.w, q.x, q.y, q.z}, {pose.position.x, pose.position.y, pose.position.z});
}

Vector6d from_message(const geometry_msgs::Twist& twist) {
  Vector6d result;
  result << twist.linear.x, twist.linear.y, twist.linear.z,  //
      twist.angular.x, twist.angular.y, twist.angular.z;
  return result;
}

Pose from_message(const geometry_msgs::Transform& transform) {
  const auto& q = transform.rotation;
  return checked({q.w, q.x, q.y, q.z}, from_message(transform.translation));
}

geometry_msgs::Vector3 to_message(const Eigen::Vector3d& vector) {
  geometry_msgs::Vector3 message;
  message.x = vector.x();
  message.y = vector.y();
  message.z = vector.z();
  return message;
}

Eigen::Vector3d from_message(const geometry_msgs::Vector3& vector) {
  return {vector.x, vector.y, vector.z};
}

geometry_msgs::Twist to_twist(const Vector6d& twist) {
  geometry_msgs::Twist message;
  message.linear = to_message(Eigen::Vector3d(twist.head<3>()));
  message.angular = to_message(Eigen::Vector3d(twist.tail<3>()));
  return message;
}

CovarianceArray to_array(const Covariance6& covariance) {
  CovarianceArray values;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data()) = symmetric(covariance);
  return values;
}

Covariance6 from_array(const CovarianceArray& values) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data());
}

std::string frame_name(const std::string& frame_id) {
  return frame_id.substr(std::min(frame_id.find_first_not_of('/'), frame_id.size()));
}

}  // namespace lidar_mapping::ros_border
