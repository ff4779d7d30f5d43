#include "lidar_mapping/front_end/motion_filter.hpp"

#include <Eigen/LU>

#include "lidar_mapping/common/covariance.hpp"

namespace lidar_mapping::front_end {

Pose moved(const Pose& T, const Vector6d& twist, double seconds) {
  const Eigen::Vector3d rotation = seconds * twist.tail<3>();
  const double angle = rotation.norm();
  // The left Jacobian of SO(3) takes the turning of the axes under way into account.
  const Eigen::Matrix3d w = skew(rotation);
  const double a =
      angle < 1e-4 ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double b = angle < 1e-4 ? 1.0 / 6.0 - angle * angle / 120.0
                                : (angle - std::sin(angle)) / (angle * angle * angle);
  const Eigen::Matrix3d J = Eigen::Matrix3d::Identity() + a * w + b * w * w;
  return T * Pose{exp_so3(rotation), J * (seconds * twist.head<3>())};
}

MotionFilter::MotionFilter(double acceleration_sigma, double angular_acceleration_sigma)
    : acceleration_sigma_(acceleration_sigma),
      angular_acceleration_sigma_(angular_acceleration_sigma) {}

void MotionFilter::reset(const Pose& pose, double speed_sigma, double rate_sigma) {
  state_ = {pose, Vector6d::Zero()};
  // The first pose is known by definition.
  covariance_.setZero();
  covariance_.topLeftCorner<6, 6>() = diagonal_covariance(1e-4, 1e-5);
  covariance_.bottomRightCorner<6, 6>() = diagonal_covariance(speed_sigma, rate_sigma);
}

void MotionFilter::predict(double seconds) {
  const Pose step = moved(Pose{}, state_.twist, seconds);
  Matrix12d F = Matrix12d::Identity();
  F.topLeftCorner<6, 6>() = adjoint(step.inverse());
  F.topRightCorner<6, 6>() = seconds * Matrix6d::Identity();
  Vector6d variance;
  variance.head<3>().setConstant(acceleration_sigma_ * acceleration_sigma_);
  variance.tail<3>().setConstant(angular_acceleration_sigma_ * angular_acceleration_sigma_);
  const double t2 = seconds * seconds;
  covariance_ = F * covariance_ * F.transpose();
  covariance_.topLeftCorner<6, 6>().diagonal() += 0.25 * t2 * t2 * variance;
  covariance_.topRightCorner<6, 6>().diagonal() += 0.5 * t2 * seconds * variance;
  covariance_.bottomLeftCorner<6, 6>().diagonal() += 0.5 * t2 * seconds * variance;
  covariance_.bottomRightCorner<6, 6>().diagonal() += t2 * variance;
  state_.T_map_sensor = state_.T_map_sensor * step;
}

void MotionFilter::measure_twist(int first, const Eigen::Vector3d& measured, double sigma) {
  Eigen::Matrix<double, 3, 12> H = Eigen::Matrix<double, 3, 12>::Zero();
  H.block<3, 3>(0, 6 + first).setIdentity();
  const Eigen::Matrix3d innovation_covariance =
      H * covariance_ * H.transpose() + sigma * sigma * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 12, 3> gain =
      covariance_ * H.transpose() * innovation_covariance.inverse();
  const Eigen::Vector3d innovation = measured - state_.twist.segment<3>(first);
  state_ = registration::perturbed(state_, Vector12d(gain * innovation));
  const Matrix12d rest = Matrix12d::Identity() - gain * H;
  // Joseph's form stays symmetric and positive.
  covariance_ = rest * covariance_ * rest.transpose() + sigma * sigma * gain * gain.transpose();
}

void MotionFilter::set(const MotionState& state, const Matrix12d& covariance) {
  state_ = state;
  covariance_ = 0.5 * (covariance + covariance.transpose());
}

registration::MotionBelief MotionFilter::belief() const { return {state_, covariance_.inverse()}; }

}  // namespace lidar_mapping::front_end
