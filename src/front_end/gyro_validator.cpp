// SPDX-License-Identifier: BSD-3-Clause
#include "gyro_validator.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

/// Sweeps leave out at most this share of the time: what happens meanwhile nobody has measured.
constexpr double kMaxUncoveredFraction = 0.3;
/// So many matches are looked at before a gyro is used.
constexpr int kMinMatches = 5;
constexpr double kBiasRate = 0.02;
constexpr double kErrorRate = 0.1;
/// That much worse than no gyro (in its error) is one that is wrong: matches err, too.
constexpr double kMinErrorRatio = 1.5;
/// Standard deviation at best, rad/s: scale and axes of cheap gyros are off by 1 % each, that is so
/// much at 1.4 rad/s. One that is held to more firmly turns the map away from the points.
constexpr double kLeastSigma = 0.02;

/// A gyro may say so many times the turning that it was right about, or that of a slow vehicle
/// (rad/s): degrees for radians are 57 times, and a quick turn takes more than one scan to begin.
constexpr double kMaxTurnRatio = 10.0;
constexpr double kSlowTurn = 0.1;
/// Right is one that is off by less than this share.
constexpr double kMaxErrorOfConfirmed = 0.5;

double squared_error(const Eigen::Quaterniond& predicted, const Eigen::Quaterniond& matched,
                     double seconds) {
  return (log_so3(predicted.conjugate() * matched) / seconds).squaredNorm() / 3.0;
}

}  // namespace

bool GyroValidator::accepts(const MotionPrior& prior) const {
  const double max_rate = kMaxTurnRatio * std::max(kSlowTurn, confirmed_rate_);
  const bool is_plausible = !prior.angular_velocity || prior.angular_velocity->norm() <= max_rate;
  return is_plausible && !is_distrusted() &&
         (!prior.uneven_turning || prior.uneven_turning->mean_rate() <= max_rate);
}

void GyroValidator::add(const MotionPrior& prior, double seconds, double duration) {
  const std::optional<Eigen::Vector3d>& rate = prior.angular_velocity;
  accepted_ = accepts(prior);
  between_.reset();
  const bool are_adjacent = std::abs(seconds - duration) < kMaxUncoveredFraction * seconds;
  if (rate_ && rate && are_adjacent) {
    between_ = log_so3(exp_so3(0.5 * seconds * *rate_) * exp_so3(0.5 * seconds * *rate)) / seconds;
  }
  rate_ = rate;
  seconds_ = seconds;
}

std::optional<MeasuredTurning> GyroValidator::turning() const {
  if (!between_ || matches_ < kMinMatches || !accepted_) return std::nullopt;
  return MeasuredTurning{*between_ - bias_, *rate_ - bias_, sigma()};
}

MotionPrior GyroValidator::remaining_prior(MotionPrior prior) const {
  if (turning() || !accepted_) prior.angular_velocity.reset();
  return prior;
}

void GyroValidator::update(const Eigen::Quaterniond& previous,
                           const Eigen::Quaterniond& without_gyro,
                           const Eigen::Quaterniond& matched) {
  if (!between_) return;
  ++matches_;
  const Eigen::Quaterniond by_gyro = previous * exp_so3(seconds_ * (*between_ - bias_));
  const Eigen::Vector3d error = log_so3(by_gyro.conjugate() * matched) / seconds_;
  const double turned = rotation_angle(previous.conjugate() * matched) / seconds_;
  if (error.norm() < kMaxErrorOfConfirmed * turned)
    confirmed_rate_ = std::max(confirmed_rate_, turned);
  const double learning_rate = 1.0 / static_cast<double>(matches_);
  const double rate = std::max(kErrorRate, learning_rate);
  gyro_variance_ += rate * (squared_error(by_gyro, matched, seconds_) - gyro_variance_);
  variance_without_gyro_ +=
      rate * (squared_error(without_gyro, matched, seconds_) - variance_without_gyro_);
  bias_ -= std::max(kBiasRate, learning_rate) * error;
}

double GyroValidator::sigma() const { return std::max(kLeastSigma, std::sqrt(gyro_variance_)); }

bool GyroValidator::is_distrusted() const {
  return matches_ >= kMinMatches &&
         gyro_variance_ > kMinErrorRatio * kMinErrorRatio *
                              std::max(variance_without_gyro_, kLeastSigma * kLeastSigma);
}

}  // namespace lidar_mapping::front_end
