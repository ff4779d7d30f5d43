// SPDX-License-Identifier: BSD-3-Clause
#include "unobserved_travel.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Changes of the speed are looked at over this time: those of single steps are noise.
constexpr double kSpan = 1.0;  // s
constexpr double kLearningRate = 0.05;

}  // namespace

void UnobservedTravel::see(double speed, double variance, double seconds) {
  speed_variance_ = variance;
  covariance_ = 0.0;
  if (seen_for_ >= 0.0) seen_for_ += seconds;
  if (seen_for_ >= 0.0 && seen_for_ < kSpan) return;
  if (seen_for_ >= kSpan) {
    const double change = speed - seen_speed_;
    walk_ += kLearningRate * (change * change / seen_for_ - walk_);
  }
  seen_speed_ = speed;
  seen_for_ = 0.0;
}

void UnobservedTravel::pass(double information, double seconds) {
  const double predicted = speed_variance_ + walk_ * seconds;
  speed_variance_ = 1.0 / (1.0 / predicted + information);
  // The share of the error of the speed that has lasted since the scan before.
  const double lasting = speed_variance_ / predicted;
  covariance_ *= lasting;
  way_variance_ += seconds * (2.0 * covariance_ + seconds * speed_variance_);
  covariance_ += seconds * speed_variance_;
  seen_for_ = -1.0;
}

void UnobservedTravel::interrupt() {
  speed_variance_ = kUnknownSpeed;
  seen_for_ = -1.0;
  covariance_ = 0.0;
}

}  // namespace lidar_mapping::front_end
