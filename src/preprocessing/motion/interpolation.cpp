// SPDX-License-Identifier: BSD-3-Clause
#include "motion/interpolation.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// Chosen: values beyond these are no measurements but damaged messages.
constexpr double kMaxSpeed = 200.0;          // m/s: 720 km/h, faster than any vehicle that maps
constexpr double kMaxTurnRate = 5000.0;      // rad/s; even as degrees/s more than any gyro measures
constexpr double kMaxAcceleration = 5000.0;  // m/s^2: 500 g, more than any accelerometer of an IMU

/// Fraction of the time from a to b, 0 for equal stamps. The difference is computed in integers.
double fraction(Stamp a, Stamp b, Stamp stamp) {
  return a == b ? 0.0 : static_cast<double>(stamp - a) / static_cast<double>(b - a);
}

Eigen::Vector3d between(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double f) {
  return a + f * (b - a);
}

}  // namespace

ImuSample interpolated(const ImuSample& a, const ImuSample& b, Stamp stamp) {
  const double f = fraction(a.stamp, b.stamp, stamp);
  ImuSample result;
  result.stamp = stamp;
  result.angular_velocity = between(a.angular_velocity, b.angular_velocity, f);
  result.linear_acceleration = between(a.linear_acceleration, b.linear_acceleration, f);
  result.has_angular_velocity = a.has_angular_velocity && b.has_angular_velocity;
  result.has_linear_acceleration = a.has_linear_acceleration && b.has_linear_acceleration;
  if (a.orientation && b.orientation) {
    result.orientation = a.orientation->slerp(f, *b.orientation).normalized();
  }
  return result;
}

VelocitySample interpolated(const VelocitySample& a, const VelocitySample& b, Stamp stamp) {
  const double f = fraction(a.stamp, b.stamp, stamp);
  return {stamp, between(a.linear, b.linear, f), between(a.angular, b.angular, f)};
}

ImuSample in_base(const ImuSample& sample, const Pose& T_base_sensor) {
  ImuSample result = sample;
  result.angular_velocity = T_base_sensor.rotation * sample.angular_velocity;
  result.linear_acceleration = T_base_sensor.rotation * sample.linear_acceleration;
  // R_world_base = R_world_sensor * R_sensor_base.
  if (sample.orientation) {
    result.orientation = (*sample.orientation * T_base_sensor.rotation.conjugate()).normalized();
  }
  return result;
}

VelocitySample in_base(const VelocitySample& sample, const Pose& T_base_sensor) {
  VelocitySample result;
  result.stamp = sample.stamp;
  result.angular = T_base_sensor.rotation * sample.angular;
  result.linear =
      T_base_sensor.rotation * sample.linear - result.angular.cross(T_base_sensor.translation);
  return result;
}

// Comparisons with NaN are false.
bool is_plausible(const ImuSample& sample) {
  return sample.angular_velocity.norm() < kMaxTurnRate &&
         sample.linear_acceleration.norm() < kMaxAcceleration;
}

bool is_plausible(const VelocitySample& sample) {
  return sample.linear.norm() < kMaxSpeed && sample.angular.norm() < kMaxTurnRate;
}

}  // namespace lidar_mapping::preprocessing
