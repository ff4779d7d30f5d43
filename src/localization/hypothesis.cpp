// SPDX-License-Identifier: BSD-3-Clause
#include "hypothesis.hpp"

#include <algorithm>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::localization {

namespace {

/// Share of the points near the sensor that the map has to know, so that it can be asked at all.
/// Chosen.
constexpr double kLeastCoverage = 0.4;
/// Mean weight of the points above ground, those in unknown voxels included, from which on the map
/// shows what the scan sees, and below which it shows something else. Chosen between what right and
/// wrong places have in a world of boxes (test_localization).
constexpr double kAgreeing = 0.25;
constexpr double kContradicting = 0.15;
/// m: scans that far apart are independent evidence. Chosen: the edge of a voxel.
constexpr double kIndependentWay = 1.0;
/// Weight of a scan at rest, which sees nothing new but its noise. Chosen.
constexpr double kWeightAtRest = 0.1;
/// Change of the log odds by independent evidence: chosen so that several metres decide, never one.
constexpr double kOfAgreement = 1.5;
constexpr double kOfContradiction = -1.0;
constexpr double kOfUnknown = -0.02;
/// Bounds of the log odds, so that a place that was right for long can still be given up.
constexpr double kLeast = -3.0;
constexpr double kGreatest = 7.0;
/// Noise of a step beside that of odometry: the map's surfaces differ by so much from place to
/// place. Chosen; m, and rad (0.03 degrees).
constexpr double kStepNoise = 0.01;
constexpr double kStepNoiseAngle = 0.03 * kRadPerDeg;

}  // namespace

Evidence evidence_of(const MapMatch& match) {
  const Agreement& agreement = match.agreement;
  if (agreement.coverage < kLeastCoverage) return Evidence::kUnknown;
  if (!match.converged || agreement.agreement < kContradicting) return Evidence::kContradicts;
  return agreement.agreement < kAgreeing ? Evidence::kUnknown : Evidence::kAgrees;
}

void Hypothesis::move(const Pose& T_previous_base, const Covariance6& covariance) {
  estimate_.T_map_base = estimate_.T_map_base * T_previous_base;
  estimate_.covariance = compose_covariance(estimate_.covariance, T_previous_base, covariance) +
                         diagonal_covariance(kStepNoise, kStepNoiseAngle);
}

Evidence Hypothesis::update(const ScanPoints& points, MapSurfaces& map, MapMatcher& matcher,
                            double way) {
  match_ = matcher.match(points, map, estimate_);
  const Evidence evidence = evidence_of(match_);
  const double weight = std::clamp(way / kIndependentWay, kWeightAtRest, 1.0);
  switch (evidence) {
    case Evidence::kAgrees:
      add(weight * kOfAgreement);
      estimate_ = match_.estimate;
      break;
    case Evidence::kUnknown:
      add(weight * kOfUnknown);
      break;
    case Evidence::kContradicts:
      add(weight * kOfContradiction);
      break;
  }
  return evidence;
}

void Hypothesis::verify(const PoseEstimate& verified) {
  ++verifications_;
  add(kLogOddsOfVerification);
  if (match_.converged && evidence_of(match_) == Evidence::kAgrees) return;
  estimate_ = verified;  // more certain than odometry alone
}

bool Hypothesis::is_refuted() const { return log_odds_ < 0.0; }

void Hypothesis::absorb(const Hypothesis& other) {
  log_odds_ = std::max(log_odds_, other.log_odds_);
  verifications_ = std::max(verifications_, other.verifications_);
}

void Hypothesis::add(double evidence) {
  log_odds_ = std::clamp(log_odds_ + evidence, kLeast, kGreatest);
}

}  // namespace lidar_mapping::localization
