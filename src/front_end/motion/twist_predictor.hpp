// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Predicts the mean twist of the next step. There are two predictors: the twist during the last
/// sweep, and the mean twist of the last step. They are weighted by their previous errors. A
/// vehicle continues with the twist of the sweep, a walking person with the average of the last
/// steps. The velocity also continues to change as it changed from the previous step to the last
/// one, weighted by the persistence of such changes in recent steps: this is complete while a
/// vehicle brakes, and zero for the motion of a gait.
class TwistPredictor {
 public:
  /// A change of the velocity by more than `largest_acceleration` (m/s^2) is a jump of the pose and
  /// is not continued.
  explicit TwistPredictor(double largest_acceleration)
      : largest_acceleration_(largest_acceleration) {}

  /// Adds a step of `seconds`: its mean twist and the twist during the sweep at its end. Only the
  /// part of the velocity that passes `observed`, a projection, was measured. Along other
  /// directions the twist of the sweep is kept: with a small error of the pose, the mean twist
  /// would drift away.
  void update(const Vector6d& mean_twist, const Vector6d& sweep_twist, double seconds,
              const Eigen::Matrix3d& observed = Eigen::Matrix3d::Identity());
  /// The mean twist of a next step of `seconds`, and the twist at its end.
  Vector6d next(double seconds) const;
  Vector6d at_end_of_next(double seconds) const;
  /// Mean squared error per axis of the better predictor: linear (m/s)^2, angular (rad/s)^2.
  Eigen::Vector2d variance() const { return mean_error_.cwiseMin(sweep_error_); }
  /// The fraction of the change of the twist, per axis, that continues in the next step: 1 for a
  /// steady acceleration, 0 for noise and a gait.
  Vector6d change_persistence() const;

 private:
  void learn_change_persistence(const Vector6d& mean_twist, const Eigen::Matrix3d& observed);
  void learn_acceleration(const Vector6d& mean_twist, double seconds,
                          const Eigen::Matrix3d& observed);
  Vector6d from_mean(double seconds) const;
  Vector6d from_sweep(double seconds) const;
  /// Weight of the last step's mean twist; 0: linear, 1: angular.
  double mean_weight(int part) const;

  double largest_acceleration_;
  bool has_step_ = false;
  Vector6d mean_twist_ = Vector6d::Zero();
  Vector6d sweep_twist_ = Vector6d::Zero();
  double seconds_ = 0.0;  ///< of the last step
  Eigen::Matrix3d observed_ = Eigen::Matrix3d::Identity();
  /// Change of the twist per second with which the forecast continues. The angular part is zero.
  Vector6d acceleration_ = Vector6d::Zero();
  Eigen::Vector2d mean_error_ = Eigen::Vector2d::Zero();  ///< squared, linear and angular
  Eigen::Vector2d sweep_error_ = Eigen::Vector2d::Zero();
  Vector6d continued_change_ = Vector6d::Zero();  ///< of the twist, times the change before
  Vector6d squared_change_ = Vector6d::Zero();
  Eigen::Vector3d measured_acceleration_ = Eigen::Vector3d::Zero();   ///< m/s^2, the last one
  Eigen::Vector3d continued_acceleration_ = Eigen::Vector3d::Zero();  ///< times the one before
  Eigen::Vector3d squared_acceleration_ = Eigen::Vector3d::Zero();
};

}  // namespace lidar_mapping::front_end
