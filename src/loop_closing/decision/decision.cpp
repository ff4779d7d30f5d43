// SPDX-License-Identifier: BSD-3-Clause
#include "decision/decision.hpp"

#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/text.hpp"

#include "sight.hpp"

namespace lidar_mapping::loop_closing {

namespace {

constexpr double kHeightQuantile = 10.8;    // 99.9 % of chi-square, one degree of freedom
constexpr double kMaxRoofedFraction = 0.2;  // of cells; chosen: trees and signs give less
constexpr double kGnssQuantile = 3.3;       // standard deviations: 99.9 % of a normal distribution

// Within these standard deviations only one location is possible, and within these differences two
// poses are one. Chosen: three of them are less than a lane, half a storey and the turn to another
// street.
constexpr double kCertainHorizontal = 1.0;    // m
constexpr double kCertainVertical = 0.5;      // m; storeys are 3 m apart
constexpr double kCertainRotation = 0.35;     // rad
constexpr double kExpectedInnovation = 12.6;  // 95 % of chi-square, six degrees of freedom

// Of key frames that are not close, by the range of sight. Measured: what is off by more than 0.06
// m or 0.3 degrees has less overlap or a larger standard deviation (doc/results/loop_closing.md).
constexpr double kFarMargin = 0.65;
constexpr double kMaxFarRotation = 0.005;  // rad, standard deviation

// Fraction of the points. Measured: right candidates have at most 0.06, 19 of 20 other places
// more than this limit (doc/results/loop_closing.md).
constexpr double kMaxStartViolation = 0.15;

/// m, horizontal standard deviation. Chosen: candidates at different locations are ten metres apart
/// (loop_closer.cpp). Tried: with 1 m right candidates of walks and flights are refused, whose
/// starting poses are less exact; with the range of sight hardly any other place is.
constexpr double kSeveralLocations = 10.0;

using FailedCheck = std::optional<Decision>;
using Config = LoopClosingConfig;

Decision refused(const std::string& reason) { return {Verdict::kRefused, reason}; }

FailedCheck check_convergence(const Match& match) {
  if (match.alignment.converged) return std::nullopt;
  return refused("the registration did not converge in " +
                 std::to_string(match.alignment.iterations) + " iterations");
}

FailedCheck check_tested_points(const MatchFigures& figures, const Config& config) {
  if (figures.tested_points >= config.min_tested_points) return std::nullopt;
  return Decision{Verdict::kUndecided,
                  figure_sentence("points above ground", figures.tested_points, "below",
                                  config.min_tested_points, "min_tested_points")};
}

/// Largest standard deviation of the rotation that the match leaves, rad.
double rotation_stddev(const Match& match) {
  const Eigen::Matrix3d covariance = match.alignment.covariance.bottomRightCorner<3, 3>();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()[2]);
}

/// Key frames that are not close have to determine all angles, which an opening to the next room
/// does not. By sight, more of what they see has to fit, too.
FailedCheck check_far_match(const Match& match, bool by_sight) {
  if (by_sight && margin_of(match.figures) <= kFarMargin) {
    return refused(figure_sentence(
        "overlap minus twice the free-space violation of key frames that are not close",
        margin_of(match.figures), "not above", kFarMargin, "max_loop_distance by sight"));
  }
  if (rotation_stddev(match) <= kMaxFarRotation) return std::nullopt;
  return refused(
      figure_sentence("standard deviation of the rotation in rad of key frames that are not close",
                      rotation_stddev(match), "above", kMaxFarRotation, "range of sight"));
}

FailedCheck check_distance(const Match& match, const Config& config) {
  const double distance = match.alignment.T_target_source.translation.norm();
  const bool by_sight = config.max_loop_distance < 0.0;
  const double limit = loop_distance_limit(match.figures.sight, config);
  if (distance > limit) {
    return refused(figure_sentence("distance of the key frames in m", distance, "above", limit,
                                   by_sight ? "max_loop_distance by sight" : "max_loop_distance"));
  }
  if (is_close(distance, match.figures.sight)) return std::nullopt;
  return check_far_match(match, by_sight);
}

FailedCheck check_figures(const MatchFigures& figures, const Config& config) {
  if (margin_of(figures) <= config.overlap_margin_limit) {
    return refused(figure_sentence("overlap minus twice the free-space violation",
                                   margin_of(figures), "not above", config.overlap_margin_limit,
                                   "overlap_margin_limit"));
  }
  if (figures.horizontal_eigenvalue <= config.eigenvalue_limit) {
    return refused(figure_sentence("horizontal eigenvalue", figures.horizontal_eigenvalue,
                                   "not above", config.eigenvalue_limit, "eigenvalue_limit"));
  }
  if (config.fitness_score_limit > 0.0 && figures.fitness > config.fitness_score_limit) {
    return refused(figure_sentence("fitness", figures.fitness, "above", config.fitness_score_limit,
                                   "fitness_score_limit"));
  }
  return std::nullopt;
}

FailedCheck check_estimate(const Match& match, const Prior& prior, const Config& config) {
  if (!prior.anchored) return std::nullopt;
  const Innovation innovation = innovation_of(prior, match.alignment.T_target_source);
  if (innovation.height > kHeightQuantile) {
    return refused(figure_sentence("normalised height difference from the estimate",
                                   innovation.height, "above", kHeightQuantile, "vertical_drift"));
  }
  if (innovation.whole > config.innovation_limit) {
    return refused(figure_sentence("normalised difference from the estimate", innovation.whole,
                                   "above", config.innovation_limit, "innovation_limit"));
  }
  return std::nullopt;
}

/// Storeys of one building look alike. After a jump in height the odometry may be on the wrong one.
FailedCheck check_storey(const MatchFigures& figures, const Prior& prior) {
  if (!prior.anchored || prior.height_jumps == 0.0 || figures.roofed <= kMaxRoofedFraction)
    return std::nullopt;
  const std::string condition =
      formatted("odometry jumped %.3g m in height between the two: the storey is unknown",
                prior.height_jumps);
  return Decision{Verdict::kUndecided,
                  figure_sentence("fraction of the place under a roof", figures.roofed, "above",
                                  kMaxRoofedFraction, condition)};
}

FailedCheck check_gnss(const Match& match, const Prior& prior) {
  if (!gnss_is_more_certain(prior)) return std::nullopt;
  const double distance = match.alignment.T_target_source.translation.head<2>().norm();
  const double limit = kGnssQuantile * prior.gnss->sigma;
  const double deviation = std::abs(distance - prior.gnss->value);
  if (deviation <= limit) return std::nullopt;
  return refused(figure_sentence("difference of the distance from that of GNSS in m", deviation,
                                 "above", limit, "covariance of the GNSS positions"));
}

}  // namespace

double margin_of(const MatchFigures& figures) {
  return figures.overlap - 2.0 * figures.free_space_violation;
}

std::string figure_sentence(const std::string& figure, double value, const std::string& relation,
                            double limit, const std::string& parameter) {
  return formatted("%s %.3g %s the limit %.3g (%s)", figure.c_str(), value, relation.c_str(), limit,
                   parameter.c_str());
}

bool admits_other_places(const Prior& prior) {
  return prior.anchored && prior.sigma_horizontal > kSeveralLocations;
}

std::optional<Decision> refused_at_start(double free_space_violation) {
  if (free_space_violation <= kMaxStartViolation) return std::nullopt;
  return refused(figure_sentence("free-space violation at the starting pose", free_space_violation,
                                 "above", kMaxStartViolation, "free space before the match"));
}

Decision decide(const Match& match, const Prior& prior, const LoopClosingConfig& config) {
  if (const auto failed = check_convergence(match)) return *failed;
  if (const auto failed = check_tested_points(match.figures, config)) return *failed;
  if (const auto failed = check_figures(match.figures, config)) return *failed;
  if (const auto failed = check_distance(match, config)) return *failed;
  if (const auto failed = check_estimate(match, prior, config)) return *failed;
  if (const auto failed = check_storey(match.figures, prior)) return *failed;
  if (const auto failed = check_gnss(match, prior)) return *failed;
  return {Verdict::kAccepted,
          figure_sentence("overlap minus twice the free-space violation", margin_of(match.figures),
                          "above", config.overlap_margin_limit, "overlap_margin_limit")};
}

bool is_unambiguous(const Match& match, const Prior& prior) {
  if (!prior.anchored || prior.height_jumps > 0.0) return false;
  return prior.sigma_horizontal <= kCertainHorizontal && prior.sigma_vertical <= kCertainVertical &&
         prior.sigma_rotation <= kCertainRotation &&
         innovation_of(prior, match.alignment.T_target_source).whole <= kExpectedInnovation;
}

bool are_one_location(const Pose& a, const Pose& b) {
  const Vector6d d = difference(a, b);
  return d.head<2>().norm() <= kCertainHorizontal && std::abs(d.z()) <= kCertainVertical &&
         d.tail<3>().norm() <= kCertainRotation;
}

}  // namespace lidar_mapping::loop_closing
