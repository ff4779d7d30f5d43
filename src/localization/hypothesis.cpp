// SPDX-License-Identifier: BSD-3-Clause
#include "hypothesis.hpp"

#include <algorithm>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::localization {

namespace {

/// Fraction of the points near the sensor that the map has to know, so that it can be asked at all.
/// Chosen.
constexpr double kLeastCoverage = 0.4;
/// Mean weight of the points above ground, those in unknown voxels included, from which on the map
/// shows what the scan sees, and below which it shows something else. Chosen between what right and
/// wrong places have in a world of boxes (test_localization).
constexpr double kAgreeing = 0.25;
constexpr double kContradicting = 0.15;
/// Points within 40 m that a scan needs, so that it can tell anything. Chosen: a scan has 500 and
/// more, also of 16 beams in a field; a covered sensor has some tens.
constexpr std::size_t kLeastPoints = 150;
/// Fraction of the usual agreement below which something else is seen, also where that agrees in
/// part: streets have walls on both sides and a road between. Chosen.
constexpr double kUsualFraction = 0.6;
/// m over which the usual agreement is taken. Chosen: some houses.
constexpr double kUsualDistance = 20.0;
/// m of agreement, and the agreement that each scan of it has, that confirm a place that no
/// verification confirms, because too little stands there. Chosen.
constexpr double kConfirmingDistance = 30.0;
constexpr double kConfirmingAgreement = 0.5;
/// m: scans that far apart are independent evidence. Chosen: the edge of a voxel.
constexpr double kIndependentDistance = 1.0;
/// Weight of a scan at rest, which sees nothing new but its noise. Chosen.
constexpr double kWeightAtRest = 0.1;
/// Change of the log odds by independent evidence: chosen so that several metres decide, never one.
constexpr double kOfAgreement = 1.5;
constexpr double kOfContradiction = -1.0;
constexpr double kOfUnknown = -0.02;
constexpr double kOfRefusal = -0.2;  // where little stands, also right places are refused
/// Differences of the agreement below this tell no places apart: cars were parked elsewhere.
/// Chosen.
constexpr double kSameAgreement = 0.15;
/// Log odds for each metre on which another place explains all of the scan and this one nothing.
/// Chosen: as if three objects for each ten metres were seen, which a house or a truck is.
constexpr double kOfDifference = 0.4;
/// Greatest deficit, so that a place can still become the best one.
constexpr double kGreatestDeficit = 12.0;
/// Bounds of the log odds, so that a place that was right for long can still be given up.
constexpr double kLeast = -3.0;
constexpr double kGreatest = 7.0;
/// Noise of a step beside that of odometry: the map's surfaces differ by so much from place to
/// place. Chosen; m, and rad (0.03 degrees).
constexpr double kStepNoise = 0.01;
constexpr double kStepNoiseAngle = 0.03 * kRadPerDeg;

double weight_of(double distance) {
  return std::clamp(distance / kIndependentDistance, kWeightAtRest, 1.0);
}

double log_odds_of(Evidence evidence) {
  switch (evidence) {
    case Evidence::kAgrees:
      return kOfAgreement;
    case Evidence::kUnconfirmed:
    case Evidence::kUnknown:
      return kOfUnknown;
    case Evidence::kContradicts:
      break;
  }
  return kOfContradiction;
}

}  // namespace

Evidence evidence_of(const MapMatch& match) {
  const Agreement& agreement = match.agreement;
  if (agreement.points < kLeastPoints) return Evidence::kUnknown;
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
                            double distance) {
  match_ = matcher.match(points, map, estimate_);
  evidence_ = judged();
  remember(distance);
  add(weight_of(distance) * log_odds_of(evidence_));
  if (evidence_ == Evidence::kAgrees) estimate_ = match_.estimate;
  return evidence_;
}

/// A vehicle that was carried to another street finds walls there, too. So a place has to agree
/// about as well as before, and after an interruption it has to be confirmed.
Evidence Hypothesis::judged() const {
  const Evidence evidence = evidence_of(match_);
  if (evidence != Evidence::kAgrees) return evidence;
  if (match_.agreement.agreement < kUsualFraction * usual_agreement_) return Evidence::kUnknown;
  const bool is_confirmed = is_confirmed_ || agreeing_distance_ > kConfirmingDistance;
  return is_confirmed ? Evidence::kAgrees : Evidence::kUnconfirmed;
}

void Hypothesis::remember(double distance) {
  const double agreement = match_.agreement.agreement;
  if (match_.agreement.points >= kLeastPoints) {
    usual_agreement_ += std::min(1.0, distance / kUsualDistance) * (agreement - usual_agreement_);
  }
  if (evidence_ == Evidence::kUnknown || evidence_ == Evidence::kContradicts) is_confirmed_ = false;
  const bool agrees = evidence_of(match_) == Evidence::kAgrees && agreement > kConfirmingAgreement;
  agreeing_distance_ = agrees ? agreeing_distance_ + distance : 0.0;
}

void Hypothesis::verify(const PoseEstimate& verified) {
  ++verifications_;
  add(kLogOddsOfVerification);
  is_confirmed_ = true;
  is_found_ = true;
  if (evidence_ == Evidence::kAgrees) return;
  estimate_ = verified;  // more certain than odometry alone
}

void Hypothesis::refuse() { add(kOfRefusal); }

void Hypothesis::compare(double best, double distance) {
  const double missing = std::max(0.0, best - match_.agreement.agreement - kSameAgreement);
  deficit_ = std::min(deficit_ + weight_of(distance) * kOfDifference * missing, kGreatestDeficit);
}

void Hypothesis::absorb(const Hypothesis& other) {
  log_odds_ = std::max(log_odds_, other.log_odds_);
  deficit_ = std::min(deficit_, other.deficit_);
  verifications_ = std::max(verifications_, other.verifications_);
  is_found_ = is_found_ || other.is_found_;
}

void Hypothesis::add(double evidence) {
  log_odds_ = std::clamp(log_odds_ + evidence, kLeast, kGreatest);
}

}  // namespace lidar_mapping::localization
