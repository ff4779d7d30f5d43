#include "lidar_mapping/front_end/inertial_filter.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace lidar_mapping::front_end {
namespace {

using registration::Matrix12d;
using registration::MotionBelief;
using registration::MotionState;
using registration::Vector12d;

// Blocks of the errors.
constexpr int kPlace = 0;
constexpr int kAttitude = 3;
constexpr int kVelocity = 6;
constexpr int kGyroBias = 9;
constexpr int kAccelerometerBias = 12;
constexpr int kGravity = 15;
// And of a motion.
constexpr int kTwist = 6;
constexpr int kRate = 9;

/// Anywhere on Earth it is within 0.03 of it.
constexpr double kStandardGravity = 9.80665;  // m/s^2
constexpr double kGravitySigma = 0.03;
// What is believed to begin with: of a vehicle that may be at speed, and of IMUs of any price.
constexpr double kSpeedSigma = 15.0;             // m/s
constexpr double kTiltSigma = 2.0;               // m/s^2 of gravity, sideways: 12 degrees
constexpr double kGyroBiasSigma = 0.03;          // rad/s
constexpr double kAccelerometerBiasSigma = 0.3;  // m/s^2
// How they wander, per square root of a second: biases with the temperature, gravity's direction
// with the drift of the odometry.
constexpr double kGyroBiasWalk = 1e-4;
constexpr double kAccelerometerBiasWalk = 1e-3;
constexpr double kGravityWalk = 2e-4;
// No IMU is better, and what is worse does not count.
constexpr double kLeastGyroNoise = 1e-4, kMostGyroNoise = 1.0;
constexpr double kLeastAccelerometerNoise = 5e-3, kMostAccelerometerNoise = 30.0;
constexpr double kLearningRate = 0.1;

/// The noise that would have led to the innovation: grows at once, falls slowly.
double learnt(double noise, double ratio, double least, double most) {
  const double factor = std::sqrt(std::max(1.0 + kLearningRate * (ratio - 1.0), 0.5));
  return std::clamp(factor * noise, least, most);
}

}  // namespace

void InertialFilter::begin(const Pose& T_odom_base, const Eigen::Vector3d& p_base_imu,
                           const Eigen::Vector3d& gravity) {
  p_base_imu_ = p_base_imu;
  state_.T_odom_imu = T_odom_base * Pose{Eigen::Quaterniond::Identity(), p_base_imu};
  state_.velocity.setZero();
  state_.gravity = kStandardGravity * gravity.normalized();
  const Matrix before = covariance_;
  covariance_.setZero();
  const auto set = [this](int block, double sigma) {
    covariance_.diagonal().segment<3>(block).setConstant(sigma * sigma);
  };
  set(kPlace, 0.01);
  set(kAttitude, 1e-3);
  set(kVelocity, kSpeedSigma);
  set(kGyroBias, kGyroBiasSigma);
  set(kAccelerometerBias, kAccelerometerBiasSigma);
  if (begun_)
    covariance_.block<6, 6>(kGyroBias, kGyroBias) = before.block<6, 6>(kGyroBias, kGyroBias);
  const Eigen::Vector3d down = gravity.normalized();
  covariance_.block<3, 3>(kGravity, kGravity) =
      kTiltSigma * kTiltSigma * (Eigen::Matrix3d::Identity() - down * down.transpose()) +
      kGravitySigma * kGravitySigma * down * down.transpose();
  begun_ = true;
}

void InertialFilter::resume(const MotionState& state, const Matrix12d& covariance) {
  const Eigen::Vector3d& l = p_base_imu_;
  state_.T_odom_imu = state.T_map_sensor * Pose{Eigen::Quaterniond::Identity(), l};
  state_.velocity =
      state.T_map_sensor.rotation * (state.twist.head<3>() + state.twist.tail<3>().cross(l));
  // From base_link's motion to that of the IMU's place.
  Eigen::Matrix<double, 9, 12> to_imu = Eigen::Matrix<double, 9, 12>::Zero();
  to_imu.topLeftCorner<9, 9>().setIdentity();
  to_imu.block<3, 3>(kPlace, kAttitude) = -skew(l);
  to_imu.block<3, 3>(kVelocity, kRate) = -skew(l);
  covariance_.topRows<9>().setZero();
  covariance_.leftCols<9>().setZero();
  covariance_.topLeftCorner<9, 9>() = to_imu * covariance * to_imu.transpose();
}

void InertialFilter::predict(const Preintegration& motion, bool has_accelerometer) {
  const double t = motion.seconds;
  const Eigen::Matrix3d R = state_.T_odom_imu.rotation_matrix();
  const Eigen::Matrix3d back = motion.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d u = R.transpose() * state_.velocity;
  const Eigen::Vector3d g = R.transpose() * state_.gravity;
  const Eigen::Vector3d u_next = back * (u + t * g + motion.velocity);

  Matrix F = Matrix::Identity();
  F.block<3, 3>(kAttitude, kAttitude) = back;
  F.block<3, 3>(kAttitude, kGyroBias) = motion.rotation_by_gyro;
  F.block<3, 3>(kPlace, kPlace) = back;
  F.block<3, 3>(kPlace, kVelocity) = t * back;
  F.block<3, 3>(kPlace, kAttitude) = -back * skew(t * u + motion.position);
  F.block<3, 3>(kPlace, kGyroBias) = back * motion.position_by_gyro;
  F.block<3, 3>(kPlace, kAccelerometerBias) = back * motion.position_by_accelerometer;
  F.block<3, 3>(kPlace, kGravity) = 0.5 * t * t * back * R.transpose();
  F.block<3, 3>(kVelocity, kVelocity) = back;
  F.block<3, 3>(kVelocity, kAttitude) = -back * skew(u + motion.velocity);
  F.block<3, 3>(kVelocity, kGyroBias) = back * motion.velocity_by_gyro;
  F.block<3, 3>(kVelocity, kAccelerometerBias) = back * motion.velocity_by_accelerometer;
  F.block<3, 3>(kVelocity, kGravity) = t * back * R.transpose();
  // The velocity is that in axes which turn.
  F.middleRows<3>(kVelocity) += skew(u_next) * F.middleRows<3>(kAttitude);

  state_.T_odom_imu.translation +=
      t * state_.velocity + 0.5 * t * t * state_.gravity + R * motion.position;
  state_.velocity += t * state_.gravity + R * motion.velocity;
  state_.T_odom_imu.rotation = (state_.T_odom_imu.rotation * motion.rotation).normalized();

  covariance_ = F * covariance_ * F.transpose();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const double noise = has_accelerometer ? accelerometer_noise_ : kMostAccelerometerNoise;
  const double a = noise * noise;
  covariance_.block<3, 3>(kPlace, kPlace) += a * t * t * t / 3.0 * I;
  covariance_.block<3, 3>(kPlace, kVelocity) += a * t * t / 2.0 * I;
  covariance_.block<3, 3>(kVelocity, kPlace) += a * t * t / 2.0 * I;
  covariance_.block<3, 3>(kVelocity, kVelocity) += a * t * I;
  Eigen::Matrix<double, kSize, 3> turning = Eigen::Matrix<double, kSize, 3>::Zero();
  turning.middleRows<3>(kAttitude) = I;
  turning.middleRows<3>(kVelocity) = skew(u_next);
  covariance_ += gyro_noise_ * gyro_noise_ * t * turning * turning.transpose();
  const auto wander = [&](int block, double walk) {
    covariance_.diagonal().segment<3>(block).array() += walk * walk * t;
  };
  wander(kGyroBias, kGyroBiasWalk);
  wander(kAccelerometerBias, kAccelerometerBiasWalk);
  wander(kGravity, kGravityWalk);
}

InertialFilter::ToMotion InertialFilter::to_motion() const {
  ToMotion to = ToMotion::Zero();
  const Eigen::Matrix3d arm = skew(p_base_imu_);
  to.topLeftCorner<9, 9>().setIdentity();
  to.block<3, 3>(kPlace, kAttitude) = arm;
  to.block<3, 3>(kRate, kGyroBias) = -Eigen::Matrix3d::Identity();
  to.block<3, 3>(kTwist, kGyroBias) = -arm;
  return to;
}

Matrix12d InertialFilter::motion_covariance(double duration) const {
  const ToMotion to = to_motion();
  Matrix12d covariance = to * covariance_ * to.transpose();
  Eigen::Matrix<double, 12, 3> noise = Eigen::Matrix<double, 12, 3>::Zero();
  noise.middleRows<3>(kRate).setIdentity();
  noise.middleRows<3>(kTwist) = skew(p_base_imu_);
  // A sweep without a duration is as long as a sample.
  const double variance = gyro_noise_ * gyro_noise_ / std::max(duration, 0.01);
  covariance += variance * noise * noise.transpose();
  return covariance;
}

MotionBelief InertialFilter::belief(const Eigen::Vector3d& rate, double duration) const {
  MotionBelief belief;
  const Eigen::Vector3d omega = rate - state_.bias.gyro;
  belief.state.T_map_sensor =
      state_.T_odom_imu * Pose{Eigen::Quaterniond::Identity(), -p_base_imu_};
  belief.state.twist.head<3>() =
      state_.T_odom_imu.rotation.conjugate() * state_.velocity - omega.cross(p_base_imu_);
  belief.state.twist.tail<3>() = omega;
  belief.information = motion_covariance(duration).inverse();
  return belief;
}

void InertialFilter::correct(const MotionBelief& believed, const MotionState& matched,
                             const Matrix12d& information, double duration) {
  const Matrix12d before = motion_covariance(duration);
  const Matrix12d after = (before.inverse() + information).inverse();
  const Vector12d innovation = difference(believed.state, matched);
  learn_noise(innovation, before - after);
  const Eigen::Matrix<double, kSize, 12> gain =
      covariance_ * to_motion().transpose() * before.inverse();
  covariance_ -= gain * (before - after) * gain.transpose();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  apply(gain * innovation);
}

void InertialFilter::apply(const Vector& error) {
  const Eigen::Vector3d u = state_.T_odom_imu.rotation.conjugate() * state_.velocity;
  state_.T_odom_imu = perturbed(state_.T_odom_imu, Vector6d(error.head<6>()));
  state_.velocity = state_.T_odom_imu.rotation * (u + error.segment<3>(kVelocity));
  state_.bias.gyro += error.segment<3>(kGyroBias);
  state_.bias.accelerometer += error.segment<3>(kAccelerometerBias);
  state_.gravity = kStandardGravity * (state_.gravity + error.segment<3>(kGravity)).normalized();
}

/// An innovation of the match is as large as what the match takes from the covariance. The gyro's
/// noise shows in the attitude, the accelerometer's in place and velocity.
void InertialFilter::learn_noise(const Vector12d& innovation, const Matrix12d& expected) {
  const auto ratio = [&](int block) {
    const double usual = expected.block<3, 3>(block, block).trace();
    return innovation.segment<3>(block).squaredNorm() / std::max(usual, 1e-12);
  };
  gyro_noise_ = learnt(gyro_noise_, ratio(kAttitude), kLeastGyroNoise, kMostGyroNoise);
  accelerometer_noise_ = learnt(accelerometer_noise_, 0.5 * (ratio(kPlace) + ratio(kTwist)),
                                kLeastAccelerometerNoise, kMostAccelerometerNoise);
}

}  // namespace lidar_mapping::front_end
