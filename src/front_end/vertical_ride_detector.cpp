// SPDX-License-Identifier: BSD-3-Clause
#include "vertical_ride_detector.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lidar_mapping::front_end {
namespace {

constexpr double kSpan = 1.0;     // s
constexpr double kLearnt = 2.0;   // s of looking on before anything is said
constexpr double kMemory = 10.0;  // s: tilt and temperature move the bias
/// m/s^2: cheap accelerometers are off by 0.3 on each axis, of which the vertical feels a half as
/// the sensor tilts by 30 degrees. Lifts for people have 0.6 to 1.2.
constexpr double kLeast = 0.35;
constexpr double kDeviations = 5.0;
constexpr double kLeastSpeed = 0.4;  // m/s; lifts for people have 1 to 2.5
constexpr double kStopped = 0.35;    // share of the speed that may be left when it has stopped
constexpr double kQuiet = 1.0;       // s
constexpr double kLongest = 60.0;    // s; the error of the speed has become as large as the speed

/// Acceleration by places at the begin, in the middle and at the end of two spans.
Eigen::Vector3d second_difference(const Eigen::Vector3d& first, const Eigen::Vector3d& middle,
                                  const Eigen::Vector3d& last, double before, double after) {
  return 2.0 / (before + after) * ((last - middle) / after - (middle - first) / before);
}

}  // namespace

void VerticalRideDetector::interrupt() {
  T_odom_last_.reset();
  steps_.clear();
  span_ = suspected_ = 0.0;
}

void VerticalRideDetector::add(const Pose& T_odom_base, double seconds,
                               const std::optional<FeltForce>& force) {
  if (T_odom_last_ && force) {
    extend(T_odom_base, seconds, *force);
  } else {
    interrupt();
  }
  T_odom_last_ = T_odom_base;
  const auto felt = felt_beside_seen();
  const double vertical = felt && learnt_ >= kLearnt ? up().dot(*felt - gravity_) : 0.0;
  if (felt && !on_ && std::abs(vertical) < limit()) learn(*felt, seconds);
  judge(vertical, seconds);
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

std::optional<Eigen::Vector3d> VerticalRideDetector::felt_beside_seen() const {
  if (span_ < 2.0 * kSpan) return std::nullopt;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d speed = Eigen::Vector3d::Zero();
  Eigen::Vector3d seen_middle = Eigen::Vector3d::Zero(), felt_middle = Eigen::Vector3d::Zero();
  double before = 0.0;
  double time = 0.0;
  for (std::size_t i = 1; i < steps_.size(); ++i) {
    const double t = steps_[i].seconds;
    place += t * speed + 0.5 * t * t * steps_[i].force;
    speed += t * steps_[i].force;
    time += t;
    if (before > 0.0 || time < kSpan) continue;
    before = time;
    seen_middle = steps_[i].p_odom_imu;
    felt_middle = place;
  }
  const double after = time - before;
  if (after < 0.5 * kSpan) return std::nullopt;  // a gap between the scans
  const Eigen::Vector3d felt =
      second_difference(Eigen::Vector3d::Zero(), felt_middle, place, before, after);
  return felt - second_difference(steps_.front().p_odom_imu, seen_middle, steps_.back().p_odom_imu,
                                  before, after);
}

void VerticalRideDetector::learn(const Eigen::Vector3d& felt, double seconds) {
  learnt_ += seconds;
  const double rate = std::min(1.0, seconds / std::min(learnt_, kMemory));
  gravity_ += rate * (felt - gravity_);
  const double vertical = up().dot(felt - gravity_);
  variance_ += rate * (vertical * vertical - variance_);
}

double VerticalRideDetector::limit() const {
  return std::max(kLeast, kDeviations * std::sqrt(variance_));
}

void VerticalRideDetector::judge(double vertical, double seconds) {
  if (on_) return go_on(vertical, seconds);
  const bool goes_on = vertical * suspected_ >= 0.0 && std::abs(vertical) >= limit();
  suspected_ = goes_on ? suspected_ + vertical * seconds : 0.0;
  if (std::abs(suspected_) < kLeastSpeed) return;
  on_ = true;
  speed_ = suspected_;
  fastest_ = std::abs(speed_);
  suspected_ = lasts_ = quiet_ = 0.0;
}

void VerticalRideDetector::go_on(double vertical, double seconds) {
  lasts_ += seconds;
  speed_ += vertical * seconds;
  fastest_ = std::max(fastest_, std::abs(speed_));
  way_ += std::abs(speed_) * seconds;
  const bool stopped = std::abs(vertical) < limit() && std::abs(speed_) < kStopped * fastest_;
  quiet_ = stopped ? quiet_ + seconds : 0.0;
  on_ = quiet_ < kQuiet && lasts_ < kLongest;
}

}  // namespace lidar_mapping::front_end
