// SPDX-License-Identifier: BSD-3-Clause
#include "candidates/prior.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Root of the 99 % quantile of chi-square, two degrees of freedom.
constexpr double kQuantile99 = 3.03;
// Error of the estimate that remains next to a constraint, by contradictions between constraints.
// Chosen: smaller values refuse true loops while others are still wrong, larger ones admit the
// neighbouring lane or storey.
constexpr double kMinHorizontalSigma = 0.5;  // m
constexpr double kMinVerticalSigma = 0.3;    // m
constexpr double kMinRotationSigma = 0.04;   // rad
constexpr double kMinGnssSigma = 1.0;        // m; chosen: receivers are worse than they report

// The height is the integral of a random walk of the pitch along the path, so that its error grows
// with the power 1.5 of the distance: it is small between the storeys of a car park and metres
// after kilometres. The distance at which vertical_drift holds, by its definition.
constexpr double kVerticalDriftDistance = 1000.0;  // m

/// Horizontal position of base_link, or of the antenna if there is no heading.
Eigen::Vector2d gnss_position(const GnssPosition& position) {
  const std::optional<Pose> T_enu_base = position.T_enu_base();
  return (T_enu_base ? T_enu_base->translation : position.p_enu_antenna).head<2>();
}

double lever_uncertainty(const GnssPosition& position) {
  return position.R_enu_base ? 0.0 : position.p_base_antenna.head<2>().norm();
}

Distance gnss_distance(const GnssPosition& a, const GnssPosition& b) {
  const Eigen::Matrix2d covariance =
      (a.covariance + b.covariance).topLeftCorner<2, 2>() +
      (kMinGnssSigma * kMinGnssSigma + std::pow(lever_uncertainty(a), 2) +
       std::pow(lever_uncertainty(b), 2)) *
          Eigen::Matrix2d::Identity();
  const double largest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1];
  return {(gnss_position(a) - gnss_position(b)).norm(), std::sqrt(largest)};
}

}  // namespace

Prior prior_between(const Trajectory& trajectory, const GraphDistance& graph_distance,
                    Trajectory::NodeId from, Trajectory::NodeId to,
                    const LoopClosingConfig& config) {
  Prior prior;
  const double path_length = graph_distance.to(from);
  prior.anchored = std::isfinite(path_length);
  prior.T_from_to = trajectory[from].T_map_base.inverse() * trajectory[to].T_map_base;
  if (prior.anchored) {
    prior.sigma_horizontal = config.horizontal_drift * path_length;
    prior.sigma_vertical =
        config.vertical_drift * path_length * std::sqrt(path_length / kVerticalDriftDistance);
    prior.sigma_rotation = std::min(config.rotation_drift * path_length, kPi);
  }
  prior.height_jumps = trajectory[to].height_jumps - trajectory[from].height_jumps;
  const auto& a = trajectory[from].gnss;
  const auto& b = trajectory[to].gnss;
  if (config.gnss_candidates && a && b) prior.gnss = gnss_distance(*a, *b);
  return prior;
}

bool gnss_is_more_certain(const Prior& prior) {
  return prior.gnss && (!prior.anchored || prior.gnss->sigma < prior.sigma_horizontal);
}

bool may_overlap(const Prior& prior, const LoopClosingConfig& config) {
  const bool by_gnss = gnss_is_more_certain(prior);
  if (!by_gnss && !prior.anchored) return true;
  const double sigma = by_gnss ? prior.gnss->sigma : prior.sigma_horizontal;
  const double distance =
      by_gnss ? prior.gnss->value : prior.T_from_to.translation.head<2>().norm();
  const double radius = config.detect_area + kQuantile99 * sigma;
  if (distance > std::min(radius, config.distance_thresh)) return false;
  if (!prior.anchored) return true;
  // A street between the two may climb, but only by 10 % of their distance.
  const double max_climb = 0.1 * prior.T_from_to.translation.head<2>().norm();
  return std::abs(prior.T_from_to.translation.z()) <=
         2.0 * kMinVerticalSigma + max_climb + kQuantile99 * prior.sigma_vertical;
}

double largest_radius(double path_length, const LoopClosingConfig& config) {
  return std::min(config.detect_area + kQuantile99 * config.horizontal_drift * path_length,
                  config.distance_thresh);
}

Innovation innovation_of(const Prior& prior, const Pose& T_from_to) {
  const Vector6d d = difference(prior.T_from_to, T_from_to);
  const double horizontal = std::pow(prior.sigma_horizontal, 2) + std::pow(kMinHorizontalSigma, 2);
  const double vertical = std::pow(prior.sigma_vertical, 2) + std::pow(kMinVerticalSigma, 2);
  const double rotation = std::pow(prior.sigma_rotation, 2) + std::pow(kMinRotationSigma, 2);
  const double height = d[2] * d[2] / vertical;
  return {d.head<2>().squaredNorm() / horizontal + height + d.tail<3>().squaredNorm() / rotation,
          height};
}

}  // namespace lidar_mapping::loop_closing
