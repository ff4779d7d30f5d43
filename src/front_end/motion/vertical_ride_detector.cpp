// SPDX-License-Identifier: BSD-3-Clause
#include "motion/vertical_ride_detector.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lidar_mapping::front_end {
namespace {

// s, over which positions are compared. Chosen: longer than a step of a gait, shorter than a lift
// accelerates.
constexpr double kSpan = 1.0;
constexpr double kLearningTime = 2.0;  // s before anything is detected; chosen: two of kSpan
constexpr double kMemory = 10.0;       // s; chosen: tilt and temperature change the bias
/// m/s^2. Chosen: cheap accelerometers have errors of 0.3 on each axis; half of it acts on the
/// vertical when the sensor tilts by 30 degrees. Passenger lifts have 0.6 to 1.2.
constexpr double kMinAcceleration = 0.35;
constexpr double kMinSigmas = 5.0;  // chosen: differences of successive scans err alike
constexpr double kMinSpeed = 0.4;   // m/s; chosen: passenger lifts have 1 to 2.5
/// Fraction of the peak speed that may remain when the lift has stopped. Chosen: the integrated
/// speed may be off by as much.
constexpr double kStoppedFraction = 0.35;
constexpr double kQuietTime = 1.0;  // s; chosen: as long as kSpan
/// s. Chosen: by then the error of the speed is as large as the speed.
constexpr double kMaxRideDuration = 60.0;

/// Acceleration from positions at the begin, in the middle and at the end of two intervals.
Eigen::Vector3d second_difference(const Eigen::Vector3d& first, const Eigen::Vector3d& middle,
                                  const Eigen::Vector3d& last, double before, double after) {
  return 2.0 / (before + after) * ((last - middle) / after - (middle - first) / before);
}

}  // namespace

void VerticalRideDetector::interrupt() {
  T_odom_last_.reset();
  steps_.clear();
  span_ = suspected_speed_ = 0.0;
}

void VerticalRideDetector::add(const Pose& T_odom_base, double seconds,
                               const std::optional<FeltForce>& force) {
  if (T_odom_last_ && force) {
    extend(T_odom_base, seconds, *force);
  } else {
    interrupt();
  }
  T_odom_last_ = T_odom_base;
  const auto unseen = unseen_acceleration();
  const double vertical =
      unseen && learned_for_ >= kLearningTime ? up().dot(*unseen - gravity_) : 0.0;
  if (unseen && !riding_ && std::abs(vertical) < acceleration_limit())
    learn_gravity(*unseen, seconds);
  update(vertical, seconds);
}

void VerticalRideDetector::extend(const Pose& T_odom_base, double seconds, const FeltForce& force) {
  if (steps_.empty()) steps_.push_back({0.0, *T_odom_last_ * force.p_base_imu, {}});
  const Eigen::Quaterniond R_odom_middle = T_odom_last_->rotation.slerp(0.5, T_odom_base.rotation);
  steps_.push_back({seconds, T_odom_base * force.p_base_imu, R_odom_middle * force.mean});
  span_ += seconds;
  while (span_ - steps_[1].seconds >= 2.0 * kSpan) {
    span_ -= steps_[1].seconds;
    steps_.pop_front();
  }
}

std::optional<Eigen::Vector3d> VerticalRideDetector::unseen_acceleration() const {
  if (span_ < 2.0 * kSpan) return std::nullopt;
  Eigen::Vector3d felt_position = Eigen::Vector3d::Zero();
  Eigen::Vector3d felt_speed = Eigen::Vector3d::Zero();
  Eigen::Vector3d seen_position_middle = Eigen::Vector3d::Zero(),
                  felt_position_middle = Eigen::Vector3d::Zero();
  double before = 0.0;
  double time = 0.0;
  for (std::size_t i = 1; i < steps_.size(); ++i) {
    const double t = steps_[i].seconds;
    felt_position += t * felt_speed + 0.5 * t * t * steps_[i].force;
    felt_speed += t * steps_[i].force;
    time += t;
    if (before > 0.0 || time < kSpan) continue;
    before = time;
    seen_position_middle = steps_[i].p_odom_imu;
    felt_position_middle = felt_position;
  }
  const double after = time - before;
  if (after < 0.5 * kSpan) return std::nullopt;  // a gap between the scans
  const Eigen::Vector3d unseen = second_difference(Eigen::Vector3d::Zero(), felt_position_middle,
                                                   felt_position, before, after);
  return unseen - second_difference(steps_.front().p_odom_imu, seen_position_middle,
                                    steps_.back().p_odom_imu, before, after);
}

void VerticalRideDetector::learn_gravity(const Eigen::Vector3d& unseen, double seconds) {
  learned_for_ += seconds;
  const double rate = std::min(1.0, seconds / std::min(learned_for_, kMemory));
  gravity_ += rate * (unseen - gravity_);
  const double vertical = up().dot(unseen - gravity_);
  variance_ += rate * (vertical * vertical - variance_);
}

double VerticalRideDetector::acceleration_limit() const {
  return std::max(kMinAcceleration, kMinSigmas * std::sqrt(variance_));
}

void VerticalRideDetector::update(double vertical, double seconds) {
  if (riding_) return continue_ride(vertical, seconds);
  const bool continues =
      vertical * suspected_speed_ >= 0.0 && std::abs(vertical) >= acceleration_limit();
  suspected_speed_ = continues ? suspected_speed_ + vertical * seconds : 0.0;
  if (std::abs(suspected_speed_) < kMinSpeed) return;
  riding_ = true;
  speed_ = suspected_speed_;
  peak_speed_ = std::abs(speed_);
  suspected_speed_ = ride_duration_ = quiet_for_ = 0.0;
}

void VerticalRideDetector::continue_ride(double vertical, double seconds) {
  // In a gap between the scans the ride goes on unseen, but not for longer than rides last.
  seconds = std::min(seconds, kMaxRideDuration - ride_duration_);
  ride_duration_ += seconds;
  speed_ += vertical * seconds;
  peak_speed_ = std::max(peak_speed_, std::abs(speed_));
  distance_ += std::abs(speed_) * seconds;
  const bool stopped = std::abs(vertical) < acceleration_limit() &&
                       std::abs(speed_) < kStoppedFraction * peak_speed_;
  quiet_for_ = stopped ? quiet_for_ + seconds : 0.0;
  riding_ = quiet_for_ < kQuietTime && ride_duration_ < kMaxRideDuration;
}

}  // namespace lidar_mapping::front_end
