// SPDX-License-Identifier: BSD-3-Clause
#include "motion/twist_predictor.hpp"

#include <algorithm>

namespace lidar_mapping::front_end {
namespace {

// Weight of the newest step in running means, so that they remember about ten steps. Chosen: fewer
// steps make the forecast noisy, more make it late when the way of moving changes.
constexpr double kLearningRate = 0.1;
/// Lower bound of a squared change of the twist, which avoids a division by zero. Chosen: a change
/// of 1 um/s.
constexpr double kMinSquaredChange = 1e-12;

/// Mean squared difference per axis, linear and angular.
Eigen::Vector2d squared_difference(const Vector6d& a, const Vector6d& b,
                                   const Eigen::Matrix3d& observed) {
  const Vector6d d = a - b;
  const double axes = std::max(1.0, observed.trace());
  return {(observed * d.head<3>()).squaredNorm() / axes, d.tail<3>().squaredNorm() / 3.0};
}

/// The fraction of a quantity that continues, per axis: mean product with its next value, divided
/// by the mean square.
template <typename Vector>
Vector persistence_of(const Vector& continued, const Vector& squared) {
  return continued.cwiseQuotient(squared.cwiseMax(kMinSquaredChange)).cwiseMax(0.0).cwiseMin(1.0);
}

}  // namespace

double TwistPredictor::mean_weight(int part) const {
  const double both = mean_error_[part] + sweep_error_[part];
  return both > 0.0 ? sweep_error_[part] / both : 0.0;
}

/// If the acceleration is steady, the twist changes from the middle of a step to its end as much as
/// from there to the middle of the next step. If it was noise, the two changes have opposite signs.
void TwistPredictor::learn_change_persistence(const Vector6d& mean_twist,
                                              const Eigen::Matrix3d& observed) {
  Vector6d before = sweep_twist_ - mean_twist_;
  Vector6d after = mean_twist - sweep_twist_;
  before.head<3>() = observed * before.head<3>();
  after.head<3>() = observed * after.head<3>();
  continued_change_ += kLearningRate * (before.cwiseProduct(after) - continued_change_);
  squared_change_ += kLearningRate * (before.cwiseProduct(before) - squared_change_);
}

Vector6d TwistPredictor::change_persistence() const {
  return persistence_of(continued_change_, squared_change_);
}

/// The mean twist of a step is the twist at its middle.
void TwistPredictor::learn_acceleration(const Vector6d& mean_twist, double seconds,
                                        const Eigen::Matrix3d& observed) {
  const Eigen::Vector3d change = observed * (mean_twist - mean_twist_).head<3>();
  Eigen::Vector3d now = change / (0.5 * (seconds_ + seconds));
  if (now.norm() > largest_acceleration_) now.setZero();
  const Eigen::Vector3d& before = measured_acceleration_;
  continued_acceleration_ += kLearningRate * (before.cwiseProduct(now) - continued_acceleration_);
  squared_acceleration_ += kLearningRate * (before.cwiseProduct(before) - squared_acceleration_);
  measured_acceleration_ = now;
  const Eigen::Vector3d persistence =
      persistence_of(continued_acceleration_, squared_acceleration_);
  acceleration_.head<3>() = persistence.cwiseProduct(now);
}

void TwistPredictor::update(const Vector6d& mean_twist, const Vector6d& sweep_twist, double seconds,
                            const Eigen::Matrix3d& observed) {
  if (has_step_) {
    const auto learn = [&](const Vector6d& forecast, Eigen::Vector2d& error) {
      error += kLearningRate * (squared_difference(forecast, mean_twist, observed) - error);
    };
    learn(from_mean(seconds), mean_error_);
    learn(from_sweep(seconds), sweep_error_);
    learn_change_persistence(mean_twist, observed);
    learn_acceleration(mean_twist, seconds, observed);
  }
  mean_twist_ = mean_twist;
  sweep_twist_ = sweep_twist;
  seconds_ = seconds;
  observed_ = observed;
  has_step_ = true;
}

Vector6d TwistPredictor::from_mean(double seconds) const {
  return mean_twist_ + 0.5 * (seconds_ + seconds) * acceleration_;
}

Vector6d TwistPredictor::from_sweep(double seconds) const {
  return sweep_twist_ + 0.5 * seconds * acceleration_;
}

Vector6d TwistPredictor::next(double seconds) const {
  Vector6d next = from_sweep(seconds);
  const Vector6d to_mean = from_mean(seconds) - next;
  next.head<3>() += mean_weight(0) * (observed_ * to_mean.head<3>());
  next.tail<3>() += mean_weight(1) * to_mean.tail<3>();
  return next;
}

Vector6d TwistPredictor::at_end_of_next(double seconds) const {
  return next(seconds) + 0.5 * seconds * acceleration_;
}

}  // namespace lidar_mapping::front_end
