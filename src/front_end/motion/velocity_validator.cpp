// SPDX-License-Identifier: BSD-3-Clause
#include "motion/velocity_validator.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

// Standard deviations that are used before anything was learned, and their lower bound. Chosen: a
// sensor may have any error; wheels have a scale error of 1 to 3 %, and 0.02 m/s of resolution.
constexpr double kSigma = 0.3;        // m/s
constexpr double kScaleSigma = 0.03;  // of the speed
constexpr double kUsualSigma = 0.1;   // m/s
constexpr double kLeastSigma = 0.02;  // m/s
/// Weight of the prior scale of one: the scale is used once it is known better than kScaleSigma.
constexpr double kScalePrior = kSigma * kSigma / (kScaleSigma * kScaleSigma);
constexpr double kLargestCorrection = 0.3;  // of the speed; chosen: more is no wrong wheel radius

// Fractions of the past values that are discarded with each pair. Chosen: a scale stays for minutes
// (500 scans are 50 s at 10 Hz), a failure counts for two seconds, the usual error for five.
constexpr double kScaleForgetting = 0.002;
constexpr double kPeakForgetting = 0.05;
constexpr double kVarianceRate = 0.02;

// Of the speed. Chosen: what is off by more has another unit, sign or axis, or none of them; wheels
// that slip for a while are not.
constexpr double kDistrustedError = 0.5;
/// m^2/s^2, of the sum of squared speeds. Chosen: ten scans at 2 m/s.
constexpr double kLeastSquaredSpeed = 40.0;

}  // namespace

double VelocityValidator::scale() const {
  const double scale = (product_ + kScalePrior) / (square_ + kScalePrior);
  return std::clamp(scale, 1.0 - kLargestCorrection, 1.0 + kLargestCorrection);
}

void VelocityValidator::update(const Eigen::Vector3d& measured,
                               const Eigen::Vector3d& true_velocity) {
  const Eigen::Vector3d error = true_velocity - corrected(measured);
  peak_ = std::max(error.norm(), (1.0 - kPeakForgetting) * peak_);
  const double squared = error.squaredNorm() / 3.0;
  variance_ = variance_ < 0.0 ? squared : variance_ + kVarianceRate * (squared - variance_);
  product_ += measured.dot(true_velocity) - kScaleForgetting * product_;
  square_ += measured.squaredNorm() - kScaleForgetting * square_;
  squared_speed_ += true_velocity.squaredNorm() - kVarianceRate * squared_speed_;
  squared_error_ += (true_velocity - measured).squaredNorm() - kVarianceRate * squared_error_;
}

double VelocityValidator::cautious_sigma(double speed) const {
  return std::max(kSigma + kScaleSigma * speed, peak_);
}

double VelocityValidator::usual_sigma() const {
  return variance_ < 0.0 ? kUsualSigma : std::max(kLeastSigma, std::sqrt(variance_));
}

bool VelocityValidator::is_distrusted() const {
  return squared_speed_ > kLeastSquaredSpeed &&
         squared_error_ > kDistrustedError * kDistrustedError * squared_speed_;
}

}  // namespace lidar_mapping::front_end
