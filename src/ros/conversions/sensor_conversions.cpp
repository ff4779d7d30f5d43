// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include <algorithm>

#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

constexpr double kNone = -1.0;  // first element of what is not provided, by sensor_msgs/Imu
// Element (3, 3) of 6 x 6 by rows, by geometry_msgs/PoseWithCovariance.
constexpr std::size_t kRollRoll = 21;

/// By sensor_msgs/Imu's definition.
bool is_provided(const sensor_msgs::Imu::_angular_velocity_covariance_type& covariance) {
  return covariance[0] != kNone;
}

std::optional<Eigen::Quaterniond> orientation_of(const sensor_msgs::Imu& message) {
  const auto& q = message.orientation;
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  const double length = rotation.norm();
  if (!is_provided(message.orientation_covariance) || !(length > 0.9 && length < 1.1)) return {};
  return unit(rotation);
}

}  // namespace

ImuSample from_message(const sensor_msgs::Imu& message) {
  ImuSample sample;
  sample.stamp = from_ros(message.header.stamp);
  sample.has_angular_velocity = is_provided(message.angular_velocity_covariance);
  sample.has_linear_acceleration = is_provided(message.linear_acceleration_covariance);
  if (sample.has_angular_velocity) {
    sample.angular_velocity = from_message(message.angular_velocity);
  }
  if (sample.has_linear_acceleration) {
    sample.linear_acceleration = from_message(message.linear_acceleration);
  }
  sample.orientation = orientation_of(message);
  return sample;
}

sensor_msgs::Imu to_message(const ImuSample& sample, const std::string& frame_id) {
  sensor_msgs::Imu message;
  message.header = header_of(sample.stamp, frame_id);
  message.angular_velocity = to_message(sample.angular_velocity);
  message.linear_acceleration = to_message(sample.linear_acceleration);
  message.orientation = to_quaternion(sample.orientation.value_or(Eigen::Quaterniond::Identity()));
  message.orientation_covariance[0] = sample.orientation ? 0.0 : kNone;
  message.angular_velocity_covariance[0] = sample.has_angular_velocity ? 0.0 : kNone;
  message.linear_acceleration_covariance[0] = sample.has_linear_acceleration ? 0.0 : kNone;
  return message;
}

VelocitySample from_message(const geometry_msgs::TwistStamped& message) {
  return {from_ros(message.header.stamp), from_message(message.twist.linear),
          from_message(message.twist.angular)};
}

geometry_msgs::TwistStamped to_message(const VelocitySample& sample, const std::string& frame_id) {
  geometry_msgs::TwistStamped message;
  message.header = header_of(sample.stamp, frame_id);
  message.twist.linear = to_message(sample.linear);
  message.twist.angular = to_message(sample.angular);
  return message;
}

GnssFix from_message(const sensor_msgs::NavSatFix& message) {
  GnssFix fix{from_ros(message.header.stamp), message.latitude, message.longitude, message.altitude,
              message.status.status,          std::nullopt};
  if (message.position_covariance_type != sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN) {
    fix.covariance = Eigen::Map<const Eigen::Matrix3d>(message.position_covariance.data());
  }
  return fix;
}

sensor_msgs::NavSatFix to_message(const GnssFix& fix, const std::string& frame_id) {
  sensor_msgs::NavSatFix message;
  message.header = header_of(fix.stamp, frame_id);
  message.status.status = static_cast<std::int8_t>(fix.status);
  message.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
  message.latitude = fix.latitude_deg;
  message.longitude = fix.longitude_deg;
  message.altitude = fix.altitude_m;
  if (fix.covariance) {
    std::copy_n(fix.covariance->data(), 9, message.position_covariance.begin());
    message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_KNOWN;
  }
  return message;
}

nav_msgs::Odometry to_message(const GnssPosition& position, const std::string& map_frame,
                              const std::string& antenna_frame) {
  nav_msgs::Odometry message;
  message.header = header_of(position.stamp, map_frame);
  message.child_frame_id = antenna_frame;
  message.pose.pose = to_message(
      Pose{position.R_enu_base.value_or(Eigen::Quaterniond::Identity()), position.p_enu_antenna});
  Covariance6 covariance = Covariance6::Zero();
  covariance.topLeftCorner<3, 3>() = position.covariance;
  message.pose.covariance = to_array(covariance);
  if (!position.R_enu_base) message.pose.covariance[kRollRoll] = kNone;
  return message;
}

GnssPosition from_message(const nav_msgs::Odometry& message,
                          const Eigen::Vector3d& p_base_antenna) {
  const Pose pose = from_message(message.pose.pose);
  GnssPosition position;
  position.stamp = from_ros(message.header.stamp);
  position.p_enu_antenna = pose.translation;
  position.covariance = from_array(message.pose.covariance).topLeftCorner<3, 3>();
  position.p_base_antenna = p_base_antenna;
  if (message.pose.covariance[kRollRoll] != kNone) position.R_enu_base = pose.rotation;
  return position;
}

void fill(SyncedInputsMessage& message, const UnevenTurning& turning) {
  message.turning_begin = turning.begin;
  message.turning_step = turning.step;
  for (const Eigen::Quaterniond& knot : turning.R_stamp_knot) {
    message.uneven_turning.push_back(to_quaternion(knot));
  }
}

void fill(SyncedInputsMessage& message, const FeltForce& felt) {
  message.felt_since = to_ros(felt.since);
  message.felt_force = to_message(felt.mean);
  message.felt_at = to_message(felt.p_base_imu);
}

std::optional<FeltForce> felt_force_of(const SyncedInputsMessage& message) {
  const Stamp since = from_ros(message.felt_since);
  if (since == 0) return std::nullopt;
  return FeltForce{since, from_message(message.felt_force), from_message(message.felt_at)};
}

std::optional<std::uint64_t> fingerprint_of(const SyncedInputsMessage& message) {
  if (message.fingerprint == 0) return std::nullopt;
  return message.fingerprint;
}

std::optional<UnevenTurning> uneven_turning_of(const SyncedInputsMessage& message) {
  if (message.uneven_turning.empty()) return std::nullopt;
  UnevenTurning turning{message.turning_begin, message.turning_step, {}};
  for (const auto& q : message.uneven_turning) {
    turning.R_stamp_knot.emplace_back(q.w, q.x, q.y, q.z);
  }
  return turning;
}

}  // namespace lidar_mapping::ros_border
