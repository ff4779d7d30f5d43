// SPDX-License-Identifier: BSD-3-Clause
#include "accelerometer_check.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace lidar_mapping::preprocessing {
namespace {

constexpr Stamp kWindow = from_seconds(2.0);
constexpr Stamp kGap = from_seconds(0.5);
constexpr int kFewest = 20;
/// Who jumps for six seconds is no vehicle.
constexpr int kWindows = 3;
/// m/s^2: shocks and thrust add to gravity, and take off of it, but not by a third over seconds.
constexpr double kLeastGravity = 6.5;
constexpr double kMostGravity = 13.5;
/// m/s^2: by so much an axis has to follow gravity as the sensor tilts (by 0.1 rad).
constexpr double kFollows = 1.0;

}  // namespace

void AccelerometerCheck::add(const ImuSample& sample) {
  if (!sample.has_linear_acceleration) return;
  if (window_ && sample.stamp - window_->last > kGap) window_.reset();
  if (!window_) {
    window_.emplace();
    window_->begin = window_->last = sample.stamp;
    window_->first = window_->gravity = sample.linear_acceleration;
    window_->least = window_->most = sample.linear_acceleration.array();
  }
  extend(sample, *window_);
  if (sample.stamp - window_->begin < kWindow) return;
  if (window_->samples >= kFewest) conclude();
  window_.reset();
}

void AccelerometerCheck::extend(const ImuSample& sample, Window& window) {
  const Eigen::Vector3d& acceleration = sample.linear_acceleration;
  ++window.samples;
  window.sum += acceleration;
  window.sum_of_sizes += acceleration.norm();
  window.stays = window.stays && (acceleration.array() == window.first.array());
  if (sample.has_angular_velocity) {
    const double seconds = to_seconds(sample.stamp - window.last);
    window.gravity = exp_so3(-seconds * sample.angular_velocity) * window.gravity;
    window.least = window.least.min(window.gravity.array());
    window.most = window.most.max(window.gravity.array());
  }
  window.last = sample.stamp;
}

AccelerationProblem AccelerometerCheck::judged(const Window& window) const {
  // A sensor that tumbles feels gravity in all directions, one that is shaken far more than that.
  const double shaken = window.sum_of_sizes / window.samples;
  const double steady = window.sum.norm() / window.samples;
  if (shaken < kLeastGravity || steady > kMostGravity) return AccelerationProblem::kNotGravity;
  const bool is_dead = (window.stays && window.most - window.least > kFollows).any();
  return is_dead ? AccelerationProblem::kConstant : AccelerationProblem::kNone;
}

void AccelerometerCheck::conclude() {
  const AccelerationProblem judged_now = judged(*window_);
  windows_ = judged_now == seen_ ? windows_ + 1 : 1;
  seen_ = judged_now;
  if (windows_ < kWindows) return;
  problem_ = seen_;
  size_ = window_->sum.norm() / window_->samples;
}

std::string AccelerometerCheck::sentence() const {
  if (problem_ == AccelerationProblem::kConstant) {
    return "an axis of the accelerometer says the same however the sensor tilts; accelerations are "
           "not used (look for a driver that fills in made-up values)";
  }
  std::array<char, 240> text{};
  std::snprintf(text.data(), text.size(),
                "its accelerations are %.2f m/s2 in the mean, which is not gravity; they are not "
                "used (%s)",
                size_,
                size_ > 0.8 && size_ < 1.25
                    ? "they are in g: set imu_acceleration_unit to G"
                    : "an axis is dead, gravity was taken off, or the unit is another");
  return text.data();
}

}  // namespace lidar_mapping::preprocessing
