#pragma once

#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::front_end {

/// Biases of gyro (rad/s) and accelerometer (m/s^2).
struct ImuBias {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();
};

/// What an IMU measured between two instants, independent of where and how fast it was and of which
/// way is down (Forster, Carlone, Dellaert, Scaramuzza 2017, section VI): in the axes at the first
/// instant,
///   R_b = R_a rotation,  v_b = v_a + g t + R_a velocity,
///   p_b = p_a + v_a t + g t^2 / 2 + R_a position.
struct Preintegration {
  double seconds = 0.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m
  // Derivatives for the biases; that of the rotation in the axes at the second instant.
  Eigen::Matrix3d rotation_by_gyro = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d velocity_by_gyro = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d position_by_gyro = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d velocity_by_accelerometer = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d position_by_accelerometer = Eigen::Matrix3d::Zero();

  /// Goes on for `seconds` with this turning (rad/s) and specific force (m/s^2) in the middle.
  void add(const Eigen::Vector3d& angular_velocity, const Eigen::Vector3d& specific_force,
           double seconds);
};

/// By the midpoint rule over samples in the order of their stamps.
Preintegration preintegrated(const std::vector<ImuSample>& samples, const ImuBias& bias);

/// Derivative of exp_so3 at `rotation`, in the axes behind it (the right Jacobian of SO(3)).
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& rotation);

}  // namespace lidar_mapping::front_end
