#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

namespace lidar_mapping::front_end {

/// Somebody carries a sensor along and never holds it still: a smooth exact motion of 60 s whose
/// shaking is `shake` times that of a walk.
inline simulation::SmoothTrajectory shaken_motion(double shake) {
  constexpr double kStep = 0.05;
  std::vector<Vector6d> control;
  for (int i = 0; i < 1200; ++i) {
    const double t = kStep * i;
    Vector6d c;
    c << 1.2 * t + 0.03 * shake * std::sin(9.0 * t), 3.0 * std::sin(0.3 * t),
        0.04 * shake * std::sin(11.0 * t),
        0.8 * std::sin(0.5 * t) + 0.1 * shake * std::sin(5.0 * t),
        0.06 * shake * std::sin(8.0 * t + 1.0), 0.05 * shake * std::sin(7.0 * t + 2.0);
    control.push_back(c);
  }
  return simulation::SmoothTrajectory(0, kStep, std::move(control));
}

/// What an IMU of that kind shows: its errors, and where it sits.
struct ImuKind {
  double rate = 200.0;  // Hz
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();
  double gyro_noise = 0.0;           // rad/s
  double accelerometer_noise = 0.0;  // m/s^2
  Eigen::Vector3d p_base_imu = Eigen::Vector3d(0.1, -0.05, 0.2);
};

inline std::vector<ImuSample> samples_of(const simulation::SmoothTrajectory& motion,
                                         const ImuKind& kind) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  std::vector<ImuSample> samples;
  const Stamp period = from_seconds(1.0 / kind.rate);
  for (Stamp stamp = motion.begin(); stamp <= motion.end(); stamp += period) {
    const auto state =
        motion.state(stamp).of_frame({Eigen::Quaterniond::Identity(), kind.p_base_imu});
    ImuSample sample;
    sample.stamp = stamp;
    sample.angular_velocity = state.angular_velocity_base + kind.gyro_bias + noise(kind.gyro_noise);
    sample.linear_acceleration = state.T_map_base.rotation.conjugate() *
                                     (state.acceleration_map + Eigen::Vector3d(0.0, 0.0, 9.80665)) +
                                 kind.accelerometer_bias + noise(kind.accelerometer_noise);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace lidar_mapping::front_end
