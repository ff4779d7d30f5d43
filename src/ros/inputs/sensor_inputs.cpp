// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/sensor_inputs.hpp"

#include <sensor_msgs/NavSatStatus.h>

#include "lidar_mapping/preprocessing/nmea.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

VelocitySample velocity(const std_msgs::Header& header, const geometry_msgs::Twist& twist) {
  return {from_ros(header.stamp), from_message(twist.linear), from_message(twist.angular)};
}

}  // namespace

SensorInput<ImuSample> input_of(const sensor_msgs::Imu& message) {
  return {from_message(message), message.header.frame_id};
}

SensorInput<VelocitySample> input_of(const geometry_msgs::TwistStamped& message) {
  return {from_message(message), message.header.frame_id};
}

SensorInput<VelocitySample> input_of(const geometry_msgs::TwistWithCovarianceStamped& message) {
  return {velocity(message.header, message.twist.twist), message.header.frame_id};
}

SensorInput<VelocitySample> input_of(const nav_msgs::Odometry& message) {
  return {velocity(message.header, message.twist.twist), message.child_frame_id};
}

SensorInput<GnssFix> input_of(const sensor_msgs::NavSatFix& message) {
  return {from_message(message), message.header.frame_id};
}

SensorInput<GnssFix> input_of(const GeoPointStamped& message) {
  return {{from_ros(message.header.stamp), message.latitude, message.longitude, message.altitude,
           sensor_msgs::NavSatStatus::STATUS_FIX, std::nullopt},
          message.header.frame_id};
}

std::optional<SensorInput<GnssFix>> input_of(const NmeaSentence& message) {
  const auto fix = preprocessing::fix_of_nmea(message.sentence, from_ros(message.header.stamp));
  if (!fix) return std::nullopt;
  return SensorInput<GnssFix>{*fix, message.header.frame_id};
}

}  // namespace lidar_mapping::ros_border
