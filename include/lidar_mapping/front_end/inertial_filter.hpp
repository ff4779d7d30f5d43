#pragma once

#include "lidar_mapping/front_end/preintegration.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// Where an IMU is, how fast, and what is wrong with it. Axes are those of base_link.
struct InertialState {
  Pose T_odom_imu;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, in odom
  ImuBias bias;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< m/s^2, in odom, downwards
};

/// Error-state Kalman filter over pose, velocity, both biases and gravity: predicted by what the
/// IMU measured between two sweeps, corrected by what a match found of pose and twist
/// (doc/front_end.md). The noise of the IMU is learnt from how far off its predictions are.
class InertialFilter {
 public:
  /// Of the errors: place and attitude (axes of base_link), velocity (likewise), gyro's bias,
  /// accelerometer's bias, gravity (odom).
  static constexpr int kSize = 18;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  /// A map begins: pose known, velocity not; `gravity` roughly, but for its size. Biases that were
  /// learnt stay.
  void begin(const Pose& T_odom_base, const Eigen::Vector3d& p_base_imu,
             const Eigen::Vector3d& gravity);
  /// The pose and twist are these, as well known as that; biases and gravity stay.
  void resume(const registration::MotionState& state, const registration::Matrix12d& covariance);
  /// Without an accelerometer the way is as good as unknown.
  void predict(const Preintegration& motion, bool has_accelerometer = true);
  /// Pose of base_link and its twist during a sweep of `duration` seconds in which the gyro showed
  /// this mean rate (as measured, rad/s).
  registration::MotionBelief belief(const Eigen::Vector3d& rate, double duration) const;
  /// A match with the last belief() as what was known before came to this state, points saying
  /// `information` of it.
  void correct(const registration::MotionBelief& believed, const registration::MotionState& matched,
               const registration::Matrix12d& information, double duration);

  const InertialState& state() const { return state_; }
  const Matrix& covariance() const { return covariance_; }
  /// Learnt noise: rad/s and m/s^2, each per square root of Hz.
  double gyro_noise() const { return gyro_noise_; }
  double accelerometer_noise() const { return accelerometer_noise_; }

 private:
  using ToMotion = Eigen::Matrix<double, 12, kSize>;

  ToMotion to_motion() const;
  registration::Matrix12d motion_covariance(double duration) const;
  void apply(const Vector& error);
  void learn_noise(const registration::Vector12d& innovation,
                   const registration::Matrix12d& expected);

  Eigen::Vector3d p_base_imu_ = Eigen::Vector3d::Zero();
  InertialState state_;
  Matrix covariance_ = Matrix::Identity();
  double gyro_noise_ = 1e-3;
  double accelerometer_noise_ = 0.05;
  bool begun_ = false;
};

}  // namespace lidar_mapping::front_end
