// SPDX-License-Identifier: BSD-3-Clause
#include "motion/unobserved_travel.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Interval over which changes of the speed are computed. Chosen: those of single steps are noise.
constexpr double kSpeedChangeInterval = 1.0;  // s
/// Weight of the newest change. Chosen: the last twenty seconds tell how a vehicle is driven.
constexpr double kLearningRate = 0.05;

}  // namespace

void UnobservedTravel::add_observed(double speed, double variance, double seconds) {
  speed_variance_ = variance;
  travel_speed_covariance_ = 0.0;
  if (observed_for_ >= 0.0) observed_for_ += seconds;
  if (observed_for_ >= 0.0 && observed_for_ < kSpeedChangeInterval) return;
  if (observed_for_ >= kSpeedChangeInterval) {
    const double change = speed - observed_speed_;
    speed_random_walk_ += kLearningRate * (change * change / observed_for_ - speed_random_walk_);
  }
  observed_speed_ = speed;
  observed_for_ = 0.0;
}

void UnobservedTravel::add_unobserved(double information, double seconds) {
  const double predicted = speed_variance_ + speed_random_walk_ * seconds;
  speed_variance_ = 1.0 / (1.0 / predicted + information);
  // The fraction of the speed's error that persists since the previous scan.
  const double persistence = speed_variance_ / predicted;
  travel_speed_covariance_ *= persistence;
  travel_variance_ += seconds * (2.0 * travel_speed_covariance_ + seconds * speed_variance_);
  travel_speed_covariance_ += seconds * speed_variance_;
  observed_for_ = -1.0;
}

void UnobservedTravel::interrupt() {
  speed_variance_ = kUnknownSpeed;
  observed_for_ = -1.0;
  travel_speed_covariance_ = 0.0;
}

}  // namespace lidar_mapping::front_end
