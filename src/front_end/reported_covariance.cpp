// SPDX-License-Identifier: BSD-3-Clause
#include "reported_covariance.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace lidar_mapping::front_end {

using registration::Matrix12d;
using registration::NdtMatch;

namespace {

/// Weight of the points in the covariance that is reported, in units of their weight in the filter,
/// where they lie as far from their planes as these claim. On smooth walls they lie nearer, on
/// hedges and rough ground farther: the root of that variance counts, the mean between what the
/// planes claim and what the residuals show, as part of the planes' errors is no residual.
constexpr double kReportedWeight = 40.0;
/// A map of one scan fits itself better than it should.
constexpr double kLeastResidualVariance = 0.05;

// A map of few scans of a sensor with few rings has planes that lean, and all points that meet one
// err together: the fewer of them find a plane, the worse. Measured on simulated drives.
constexpr double kYoungOverlap = 0.75;  // share of points with a plane that is enough
constexpr double kLeastOverlap = 0.45;
constexpr double kYoungPower = 8.0;
constexpr double kYoungVariance = 2.5;

// Two scans that see the same part of the map err together. As new parts come into sight, each
// standing on the poses before, errors part, and then add up: measured on simulated drives.
constexpr double kSharedView = 0.3;    // of the variance of two independent poses
constexpr double kNewViewWay = 1.5;    // m
constexpr double kNewViewTurn = 0.02;  // rad

}  // namespace

Matrix12d reported_covariance(const NdtMatch& match) {
  const double weight =
      kReportedWeight / std::sqrt(std::max(kLeastResidualVariance, match.residual_variance));
  const Matrix12d information = match.information + (weight - 1.0) * match.points_information;
  return information.inverse();
}

double variance_in_young_map(const NdtMatch& match) {
  const double overlap = std::clamp(match.overlap, kLeastOverlap, kYoungOverlap);
  return kYoungVariance * std::pow(kYoungOverlap / overlap, kYoungPower);
}

Matrix12d doubt_covariance(const registration::MotionState& matched,
                           const registration::MotionBelief& prediction, double probability) {
  const registration::Vector12d d = difference(matched, prediction.state);
  return (1.0 - probability) * (d * d.transpose() + prediction.information.inverse());
}

Covariance6 motion_covariance(const Covariance6& of_from, double from_variance,
                              const Pose& T_from_to, const Covariance6& of_to, double to_variance) {
  const double parted = T_from_to.translation.norm() / kNewViewWay +
                        rotation_angle(T_from_to.rotation) / kNewViewTurn;
  return compose_covariance((kSharedView + from_variance * parted) * of_from, T_from_to,
                            (kSharedView + to_variance * parted) * of_to);
}

}  // namespace lidar_mapping::front_end
