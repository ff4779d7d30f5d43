#pragma once

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Forecasts the mean twist of the next step. The twist during the last sweep and the mean twist of
/// the last step both stand for it; whichever has foretold better has the greater say. A vehicle
/// goes on as it went during the sweep, a walking person as on the average of the last steps.
class TwistForecast {
 public:
  /// Takes in a step: its mean twist and that during the sweep at its end. Only velocities that
  /// `observed`, a projection, lets through were seen. Along others the twist stays what the
  /// sweep's has been: a pose that is off by a little would drive the mean twist away.
  void see(const Vector6d& mean_twist, const Vector6d& sweep_twist,
           const Eigen::Matrix3d& observed = Eigen::Matrix3d::Identity());
  const Vector6d& next() const { return next_; }
  /// Mean squared error per axis of the better one: linear (m/s)^2, angular (rad/s)^2.
  const Eigen::Vector2d& variance() const { return variance_; }
  /// Which share of the change of the twist, per axis, goes on in the next step: 1 for a steady
  /// acceleration, 0 for noise and a gait.
  Vector6d steadiness() const;

 private:
  void learn_steadiness(const Vector6d& mean_twist, const Eigen::Matrix3d& observed);
  /// Say of the last step's mean twist; 0: linear, 1: angular.
  double mean_share(int part) const;

  bool seen_ = false;
  Vector6d mean_twist_ = Vector6d::Zero();
  Vector6d sweep_twist_ = Vector6d::Zero();
  Vector6d next_ = Vector6d::Zero();
  Eigen::Vector2d mean_error_ = Eigen::Vector2d::Zero();  ///< squared, linear and angular
  Eigen::Vector2d sweep_error_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d variance_ = Eigen::Vector2d::Zero();
  Vector6d continued_change_ = Vector6d::Zero();  ///< of the twist, times the change before
  Vector6d squared_change_ = Vector6d::Zero();
};

}  // namespace lidar_mapping::front_end
