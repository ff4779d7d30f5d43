// SPDX-License-Identifier: BSD-3-Clause
#include "motion/gyro_validator.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

/// Largest fraction of the time that is not covered by sweeps: the rotation in between is not
/// measured. Chosen below a half, which a missing scan leaves.
constexpr double kMaxUncoveredFraction = 0.3;
/// Number of matches before a gyro is used. Chosen: fewer may agree with a wrong one by chance.
constexpr int kMinMatches = 5;
// Weights of the newest match in the running means of the bias and of the errors. Chosen: a bias
// changes over minutes, errors change with the way of moving within a second.
constexpr double kBiasRate = 0.02;
constexpr double kErrorRate = 0.1;
/// A gyro is wrong if its error is larger than that without a gyro by this factor. Chosen: a margin
/// is needed because matches have errors, too.
constexpr double kMinErrorRatio = 1.5;
/// A gyro is wrong, too, if the mean contradiction exceeds this. Measured on drives with legs: of
/// gyros that are right single sweeps have 0.01 to 0.6, of wrong axes 5 to 30. With 1.5 some right
/// ones are distrusted, with 2.5 half of the errors by wrong ones remain.
constexpr double kMaxContradiction = 2.0;
/// One sweep counts as no more than this. Chosen: a single match that is off does not decide, as it
/// adds kErrorRate of it to the mean.
constexpr double kMaxCountedContradiction = 4.0;

/// A rate is plausible up to this multiple of the largest confirmed rate, or of the rate of a slow
/// vehicle (rad/s). Chosen: degrees instead of radians give a factor of 57, and a quick turn needs
/// more than one scan to begin.
constexpr double kMaxTurnRatio = 10.0;
constexpr double kSlowTurn = 0.1;
/// A rate is confirmed if its relative error is smaller than this. Chosen: wrong units err by more,
/// and a slow turn errs by the noise of a match.
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
  // Of a sweep from which the uneven rotation was not removed only the mean is known.
  uniform_ = prior.uneven_turning || duration <= 0.0;
  seconds_ = seconds;
}

std::optional<MeasuredTurning> GyroValidator::turning() const {
  if (!between_ || matches_ < kMinMatches || !accepted_) return std::nullopt;
  return MeasuredTurning{*between_ - bias_, *rate_ - bias_, sigma(), uniform_};
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

double GyroValidator::sigma() const { return std::max(kLeastGyroSigma, std::sqrt(gyro_variance_)); }

std::optional<Eigen::Vector3d> GyroValidator::rate() const {
  if (!rate_) return std::nullopt;
  return *rate_ - bias_;
}

void GyroValidator::add_contradiction(double contradiction) {
  contradiction_ +=
      kErrorRate * (std::min(contradiction, kMaxCountedContradiction) - contradiction_);
}

bool GyroValidator::is_distrusted() const {
  const double most = kMinErrorRatio * kMinErrorRatio *
                      std::max(variance_without_gyro_, kLeastGyroSigma * kLeastGyroSigma);
  return matches_ >= kMinMatches && (gyro_variance_ > most || contradiction_ > kMaxContradiction);
}

}  // namespace lidar_mapping::front_end
