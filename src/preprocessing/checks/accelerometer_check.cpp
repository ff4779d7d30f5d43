// SPDX-License-Identifier: BSD-3-Clause
#include "checks/accelerometer_check.hpp"

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {
namespace {

// Length of a window. Chosen: longer than a bump of the road, and it bounds how late a fault is
// found.
constexpr Stamp kWindow = from_seconds(2.0);
// Longer gaps between samples begin a new window: its mean would hide what happened in between.
constexpr Stamp kMaxGap = from_seconds(0.5);
constexpr int kMinSamples = 20;  // 10 Hz; chosen: fewer give a poor mean
/// Number of windows. Chosen: no vehicle is in free fall or jumps for six seconds.
constexpr int kMinWindows = 3;
/// m/s^2, gravity (9.81) less and plus about a third. Chosen: shocks and thrust change the mean
/// acceleration, but not by that much over seconds.
constexpr double kMinGravity = 6.5;
constexpr double kMaxGravity = 13.5;
/// m/s^2: an axis must follow gravity when gravity on it changes by this much. Chosen: a tilt of
/// 0.1 rad, which is more than the errors of gyros add up to in a window.
constexpr double kMinGravityChange = 1.0;

}  // namespace

void AccelerometerCheck::add(const ImuSample& sample) {
  if (!sample.has_linear_acceleration) return;
  if (window_ && sample.stamp - window_->last > kMaxGap) window_.reset();
  if (!window_) {
    window_ = Window{};
    window_->begin = window_->last = sample.stamp;
    window_->first = window_->gravity = sample.linear_acceleration;
    window_->min_gravity = window_->max_gravity = sample.linear_acceleration.array();
  }
  extend(sample, *window_);
  if (sample.stamp - window_->begin < kWindow) return;
  if (window_->samples >= kMinSamples) finish_window();
  window_.reset();
}

void AccelerometerCheck::extend(const ImuSample& sample, Window& window) {
  const Eigen::Vector3d& acceleration = sample.linear_acceleration;
  ++window.samples;
  window.sum += acceleration;
  window.sum_of_sizes += acceleration.norm();
  window.constant_axes = window.constant_axes && (acceleration.array() == window.first.array());
  if (sample.has_angular_velocity) {
    const double seconds = to_seconds(sample.stamp - window.last);
    window.gravity = exp_so3(-seconds * sample.angular_velocity) * window.gravity;
    window.min_gravity = window.min_gravity.min(window.gravity.array());
    window.max_gravity = window.max_gravity.max(window.gravity.array());
  }
  window.last = sample.stamp;
}

AccelerationProblem AccelerometerCheck::evaluate(const Window& window) const {
  // The length of the mean is small if the sensor tumbles, and the mean of the lengths is large if
  // it is shaken.
  const double mean_size = window.sum_of_sizes / window.samples;
  const double size_of_mean = window.sum.norm() / window.samples;
  if (mean_size < kMinGravity || size_of_mean > kMaxGravity)
    return AccelerationProblem::kNotGravity;
  const bool is_constant =
      (window.constant_axes && window.max_gravity - window.min_gravity > kMinGravityChange).any();
  return is_constant ? AccelerationProblem::kConstant : AccelerationProblem::kNone;
}

void AccelerometerCheck::finish_window() {
  const AccelerationProblem problem_now = evaluate(*window_);
  equal_windows_ = problem_now == window_problem_ ? equal_windows_ + 1 : 1;
  window_problem_ = problem_now;
  if (equal_windows_ < kMinWindows) return;
  problem_ = window_problem_;
  mean_size_ = window_->sum.norm() / window_->samples;
}

std::string AccelerometerCheck::sentence() const {
  if (problem_ == AccelerationProblem::kConstant) {
    return "an axis of the accelerometer reports the same value however the sensor tilts; "
           "accelerations are not used (check whether the driver fills in constants)";
  }
  return formatted(
      "its accelerations are %.2f m/s2 in the mean, which is not gravity; they are not "
      "used (%s)",
      mean_size_,
      mean_size_ > 0.8 && mean_size_ < 1.25
          ? "they are in g: set imu_acceleration_unit to G"
          : "an axis does not measure, gravity was removed, or the unit is wrong");
}

}  // namespace lidar_mapping::preprocessing
