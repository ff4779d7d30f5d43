// SPDX-License-Identifier: BSD-3-Clause
#include "start/false_standstill_recovery.hpp"

#include <cmath>
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "local_map/vertical_structure_search.hpp"
#include "matching/degeneracy.hpp"

namespace lidar_mapping::front_end {
namespace {

/// If a larger fraction of the points finds a plane, and these constrain the sensor in all
/// directions, the match cannot miss a motion. Chosen: of few rings a sixth finds one at first.
constexpr double kMinConstrainedOverlap = 0.5;
/// With fewer points on vertical structures nothing can be decided. Chosen: they may all be on one
/// object, which may move.
constexpr std::size_t kMinPoints = 20;
/// If this fraction of them matches the map at the matched pose, the sensor stands still. Chosen
/// above a third: so many still match at the true pose after half a metre in simulated fields.
constexpr double kMinStandstillFraction = 0.6;
/// This number of scans must show a motion that is steady to this distance (m). In each of them the
/// new pose must have more evidence than the old one by the factor kMinEvidenceRatio, and in all of
/// them together by this number of standard deviations. Chosen: three poses are the least that show
/// whether a motion is steady, the distance is below a step of the search (0.3 m), and chance
/// exceeds four standard deviations once in 30,000 times.
constexpr std::size_t kHypotheses = 3;
constexpr double kMaxInconsistency = 0.25;
constexpr double kMinEvidenceSigmas = 4.0;

/// Limit for a robot that turns on the spot and continues to insert scans into its map. Chosen: of
/// one place ten scans show all there is.
constexpr int kMaxInitialScans = 10;

/// After this number of scans without a fit, the normal matches are used again. Chosen: a second at
/// 10 Hz.
constexpr int kMaxFailedFits = 10;
/// Beyond this distance (m) the map contains rings from many places, and normal matching works.
/// Chosen: the sensor is then far beyond most of the rings of its first scans.
constexpr double kMaxRecoveryDistance = 30.0;

// Standard deviations of a fitted pose, chosen as that of a point in vertical_structure_map.cpp (15
// cm), and of the twist from three of them, chosen so wide that the next fits correct it.
constexpr double kPoseSigma = 0.15;       // m
constexpr double kPoseAngleSigma = 0.01;  // rad
constexpr double kSpeedSigma = 0.5;       // m/s
constexpr double kRateSigma = 0.1;        // rad/s

/// The rings on the ground look the same elsewhere only if the sensor has neither risen nor tilted
/// since the map began: a few decimetres of height move a ring by metres. Chosen: a vehicle that
/// pulls away nods by less than two degrees, and its body rises by less than a decimetre.
constexpr double kMaxRise = 0.3;               // m
constexpr double kMaxTilt = 3.0 * kRadPerDeg;  // rad

bool is_level(const Pose& T_first_now) {
  const Eigen::Vector3d up = T_first_now.rotation * Eigen::Vector3d::UnitZ();
  return std::abs(T_first_now.translation.z()) < kMaxRise &&
         std::hypot(up.x(), up.y()) < std::sin(kMaxTilt);
}

Matrix12d recovered_covariance() {
  Matrix12d covariance = Matrix12d::Zero();
  covariance.topLeftCorner<6, 6>() = diagonal_covariance(kPoseSigma, kPoseAngleSigma);
  covariance.bottomRightCorner<6, 6>() = diagonal_covariance(kSpeedSigma, kRateSigma);
  return covariance;
}

bool is_constrained(const NdtMatch& match) {
  return match.overlap > kMinConstrainedOverlap &&
         degenerate_directions(match.pose_hessian, kSinglePlaceFraction).empty();
}

}  // namespace

void FalseStandstillRecovery::reset() { *this = FalseStandstillRecovery(); }

void FalseStandstillRecovery::insert(const SampledPoints& points, const MotionState& state) {
  if (finished_ || (!recovering_ && inserted_scans_ == kMaxInitialScans)) return;
  ++inserted_scans_;
  if (!first_pose_) first_pose_ = confirmed_pose_ = state.T_map_sensor;
  pending_.push_back({points, state});
}

void FalseStandstillRecovery::insert_pending() {
  for (const Inserted& scan : pending_) {
    map_.insert(vertical_points_at(scan.points, scan.state.twist), scan.state.T_map_sensor);
  }
  pending_.clear();
}

void FalseStandstillRecovery::finish() {
  reset();
  finished_ = true;
}

std::optional<MotionFilter> FalseStandstillRecovery::track(const SampledPoints& points,
                                                           const MotionFilter& high_noise_filter,
                                                           const Pose& predicted) {
  if (!recovering_) return std::nullopt;
  if ((predicted.translation - first_pose_->translation).norm() > kMaxRecoveryDistance) {
    finish();
    return std::nullopt;
  }
  insert_pending();
  MotionFilter recovered = high_noise_filter;
  const std::optional<Pose> pose = fit(points, high_noise_filter.state());
  if (pose) recovered.measure_planar_pose(*pose, kPoseSigma, kPoseAngleSigma);
  return recovered;
}

std::optional<MotionFilter> FalseStandstillRecovery::detect(const SampledPoints& points,
                                                            const NdtMatch& match, double seconds,
                                                            bool single_place,
                                                            const MotionFilter& filter) {
  if (!single_place || !first_pose_) finish();
  if (finished_) return std::nullopt;
  since_hypothesis_ += seconds;
  if (is_constrained(match) || !is_level(first_pose_->inverse() * match.state.T_map_sensor)) {
    confirm(match.state.T_map_sensor);
    return std::nullopt;
  }
  insert_pending();
  const std::optional<MotionState> state = find_motion(points, match.state);
  if (!state) return std::nullopt;
  MotionFilter recovered = filter;
  recovered.restart(*state, recovered_covariance());
  return recovered;
}

void FalseStandstillRecovery::confirm(const Pose& pose) {
  confirmed_pose_ = pose;
  hypotheses_.clear();
}

const Pose& FalseStandstillRecovery::last_pose() const {
  return hypotheses_.empty() ? confirmed_pose_ : hypotheses_.back().pose;
}

std::optional<FalseStandstillRecovery::Hypothesis> FalseStandstillRecovery::find_other_pose(
    const std::vector<Eigen::Vector3f>& points, const Pose& matched) {
  if (points.size() < kMinPoints) return std::nullopt;
  const VerticalStructureMap::Fit fit_here = map_.evaluate(points, matched);
  if (static_cast<double>(fit_here.matched_points) >
      kMinStandstillFraction * static_cast<double>(points.size())) {
    confirm(matched);
    return std::nullopt;
  }
  const VerticalStructureMap::Fit fit_there =
      map_.fit(points, coarse_search(map_, points, last_pose()));
  if (fit_there.evidence <= fit_here.evidence) hypotheses_.clear();
  const Eigen::Vector2d ahead = heading_of(difference(last_pose(), fit_there.T_map_sensor));
  if (fit_there.evidence < kMinEvidenceRatio * fit_here.evidence ||
      !is_distinct(map_, fit_there, ahead, points)) {
    return std::nullopt;
  }
  return Hypothesis{fit_there.T_map_sensor, 0.0, fit_there.evidence, fit_here.evidence};
}

bool FalseStandstillRecovery::is_consistent() const {
  int evidence_difference = 0;
  int evidence_sum = 0;
  for (const Hypothesis& hypothesis : hypotheses_) {
    evidence_difference += hypothesis.evidence_there - hypothesis.evidence_here;
    evidence_sum += hypothesis.evidence_there + hypothesis.evidence_here;
  }
  if (evidence_difference < kMinEvidenceSigmas * std::sqrt(evidence_sum)) return false;
  const double seconds = hypotheses_[1].seconds + hypotheses_[2].seconds;
  const Vector6d twist = twist_between(hypotheses_[0].pose, hypotheses_[2].pose, seconds);
  const Pose interpolated = moved(hypotheses_[0].pose, twist, hypotheses_[1].seconds);
  return difference(interpolated, hypotheses_[1].pose).head<3>().norm() < kMaxInconsistency;
}

std::optional<MotionState> FalseStandstillRecovery::find_motion(const SampledPoints& points,
                                                                const MotionState& matched) {
  std::optional<Hypothesis> hypothesis =
      find_other_pose(sampled_vertical_points_at(points, matched.twist), matched.T_map_sensor);
  if (!hypothesis) return std::nullopt;
  hypothesis->seconds = std::exchange(since_hypothesis_, 0.0);
  if (hypotheses_.size() == kHypotheses) hypotheses_.erase(hypotheses_.begin());
  hypotheses_.push_back(*hypothesis);
  if (hypotheses_.size() < kHypotheses || !is_consistent()) return std::nullopt;
  recovering_ = true;
  const double seconds = hypotheses_[1].seconds + hypotheses_[2].seconds;
  return MotionState{hypothesis->pose,
                     twist_between(hypotheses_[0].pose, hypothesis->pose, seconds)};
}

std::optional<Pose> FalseStandstillRecovery::fit(const SampledPoints& points,
                                                 const MotionState& predicted) {
  const std::vector<Eigen::Vector3f> vertical = sampled_vertical_points_at(points, predicted.twist);
  const VerticalStructureMap::Fit fit = map_.fit(vertical, predicted.T_map_sensor);
  if (is_distinct(map_, fit, heading_of(predicted.twist), vertical)) {
    failed_fits_ = 0;
    return fit.T_map_sensor;
  }
  if (++failed_fits_ == kMaxFailedFits) {
    failed_fits_ = 0;
    recovering_ = false;
    confirm(predicted.T_map_sensor);
  }
  return std::nullopt;
}

}  // namespace lidar_mapping::front_end
