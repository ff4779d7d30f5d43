// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/reported_covariance.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace lidar_mapping::front_end {

namespace {

/// Weight of the points in the reported covariance, in units of their weight in the filter, if
/// their distances from the planes agree with the planes' own variance. On smooth walls the
/// distances are smaller, on hedges and rough ground larger. The square root of the residual
/// variance is used: the mean between what the planes claim and what the residuals show, because a
/// part of the planes' errors does not appear in the residuals. Measured on simulated drives: with
/// this value squared errors are 0.5 to 2.1 times the covariance (doc/results/front_end.md).
constexpr double kReportedWeight = 55.0;
/// Lower bound, in units of what the planes claim; chosen because a map of one scan fits that scan
/// too well.
constexpr double kMinResidualVariance = 0.05;

// In a map of few scans from a sensor with few rings the planes are tilted, and all points on one
// plane have the same error. The fewer points find a plane, the larger is the error. Measured on
// simulated drives.
constexpr double kSufficientOverlap = 0.75;  // fraction of points with a plane that is sufficient
constexpr double kMinOverlap = 0.45;
constexpr double kOverlapExponent = 8.0;
constexpr double kInitialVarianceFactor = 2.5;

}  // namespace

double credible_residual_variance(const NdtMatch& match) {
  return std::max(kMinResidualVariance, match.residual_variance);
}

Matrix12d reported_covariance(const NdtMatch& match) {
  const double weight = kReportedWeight / std::sqrt(credible_residual_variance(match));
  const Matrix12d information = match.information + (weight - 1.0) * match.points_information;
  return information.inverse();
}

double initial_drift_variance_factor(const NdtMatch& match) {
  const double overlap = std::clamp(match.overlap, kMinOverlap, kSufficientOverlap);
  return kInitialVarianceFactor * std::pow(kSufficientOverlap / overlap, kOverlapExponent);
}

Matrix12d doubt_covariance(const MotionState& matched, const MotionBelief& prediction,
                           double probability) {
  const Vector12d d = difference(matched, prediction.state);
  return (1.0 - probability) * (d * d.transpose() + prediction.information.inverse());
}

}  // namespace lidar_mapping::front_end
