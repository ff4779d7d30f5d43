// SPDX-License-Identifier: BSD-3-Clause
#include "false_standstill_recovery.hpp"

#include <cmath>
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "degeneracy.hpp"
#include "local_map.hpp"

namespace lidar_mapping::front_end {
namespace {

/// If a larger fraction of the points finds a plane, and these constrain the sensor in all
/// directions, the match cannot miss a motion.
constexpr double kMinConstrainedOverlap = 0.5;
/// With fewer points on vertical structures nothing can be decided.
constexpr std::size_t kMinPoints = 20;
/// More points, as in streets, cost time without benefit.
constexpr std::size_t kMaxPoints = 400;
/// If this fraction of them matches the map at the matched pose, the sensor stands still.
constexpr double kMinStandstillFraction = 0.6;
/// Conditions for a new pose: the points match in at least this number of 36 directions, and the
/// evidence is larger than that of the old pose by this factor in each scan, and in all scans
/// together by this number of standard deviations.
constexpr int kMinDirections = 4;
constexpr double kMinEvidenceRatio = 1.25;
constexpr double kMinEvidenceSigmas = 4.0;
/// This number of scans must show a motion that is steady to this distance (m).
constexpr std::size_t kHypotheses = 3;
constexpr double kMaxInconsistency = 0.25;

/// Limit for a robot that turns on the spot and continues to insert scans into its map.
constexpr int kMaxInitialScans = 10;

// Search range (m); the direction of travel may be any of four directions of the sensor.
constexpr int kSearchDirections = 4;
constexpr double kSearchBehind = 2.4;
constexpr double kSearchAhead = 6.0;
constexpr double kSearchAside = 0.6;
constexpr double kSearchStep = 0.3;

/// Structures along the direction of travel fit equally well at this distance (m) ahead and behind;
/// they do not determine the pose.
constexpr double kDistinctDistance = 0.7;
/// A shorter displacement (m) or a slower motion (m/s) has no direction.
constexpr double kMinDisplacement = 0.1;
/// After this number of scans without a fit, the normal matches are used again.
constexpr int kMaxFailedFits = 10;
/// Beyond this distance (m) the map contains rings from many places, and normal matching works.
constexpr double kMaxRecoveryDistance = 30.0;

// Standard deviations of a fitted pose, and of the twist from three of them.
constexpr double kPoseSigma = 0.15;       // m
constexpr double kPoseAngleSigma = 0.01;  // rad
constexpr double kSpeedSigma = 0.5;       // m/s
constexpr double kRateSigma = 0.1;        // rad/s

/// Points on vertical structures, deskewed to the reference time.
std::vector<Eigen::Vector3f> vertical_points_at(const SampledPoints& points,
                                                const Vector6d& twist) {
  SampledPoints transformed_points;
  transform_points(points, {Pose{}, twist}, Eigen::Vector3d::Zero(), transformed_points);
  return vertical_structure_points(transformed_points);
}

/// A subset of these points, about as many as are compared.
std::vector<Eigen::Vector3f> sampled_vertical_points_at(const SampledPoints& points,
                                                        const Vector6d& twist) {
  std::vector<Eigen::Vector3f> vertical = vertical_points_at(points, twist);
  const std::size_t stride = vertical.size() / kMaxPoints + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < vertical.size(); i += stride) vertical[kept++] = vertical[i];
  vertical.resize(kept);
  return vertical;
}

Pose displaced(const Pose& pose, const Eigen::Vector2d& by) {
  Vector6d d = Vector6d::Zero();
  d.head<2>() = by;
  return perturbed(pose, d);
}

/// Unit vector in the direction of the displacement; the sensor's x axis if there is no
/// displacement.
Eigen::Vector2d heading_of(const Vector6d& displacement) {
  const Eigen::Vector2d level = displacement.head<2>();
  return level.norm() < kMinDisplacement ? Eigen::Vector2d::UnitX() : level.normalized();
}

Matrix12d recovered_covariance() {
  Matrix12d covariance = Matrix12d::Zero();
  covariance.topLeftCorner<6, 6>() = diagonal_covariance(kPoseSigma, kPoseAngleSigma);
  covariance.bottomRightCorner<6, 6>() = diagonal_covariance(kSpeedSigma, kRateSigma);
  return covariance;
}

bool is_constrained(const registration::NdtMatch& match) {
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

bool FalseStandstillRecovery::track(const SampledPoints& points,
                                    const MotionFilter& high_noise_filter, MotionFilter& filter) {
  if (!recovering_) return false;
  const MotionState& predicted = high_noise_filter.state();
  const Pose& filter_pose = filter.state().T_map_sensor;
  if ((filter_pose.translation - first_pose_->translation).norm() > kMaxRecoveryDistance) {
    finish();
    return false;
  }
  insert_pending();
  const std::optional<Pose> pose = fit(points, predicted);
  filter = high_noise_filter;
  if (pose) filter.measure_planar_pose(*pose, kPoseSigma, kPoseAngleSigma);
  return true;
}

bool FalseStandstillRecovery::detect(const SampledPoints& points,
                                     const registration::NdtMatch& match, double seconds,
                                     bool single_place, MotionFilter& filter) {
  if (!single_place || !first_pose_) finish();
  if (finished_) return false;
  since_hypothesis_ += seconds;
  if (is_constrained(match)) {
    confirm(match.state.T_map_sensor);
    return false;
  }
  insert_pending();
  const std::optional<MotionState> state = find_motion(points, match.state);
  if (state) filter.restart(*state, recovered_covariance());
  return state.has_value();
}

void FalseStandstillRecovery::confirm(const Pose& pose) {
  confirmed_pose_ = pose;
  hypotheses_.clear();
}

const Pose& FalseStandstillRecovery::last_pose() const {
  return hypotheses_.empty() ? confirmed_pose_ : hypotheses_.back().pose;
}

Pose FalseStandstillRecovery::coarse_search(const std::vector<Eigen::Vector3f>& points) const {
  Pose best = last_pose();
  std::size_t best_count = 0;
  for (int direction = 0; direction < kSearchDirections; ++direction) {
    const Eigen::Rotation2Dd heading(2.0 * kPi / kSearchDirections * direction);
    for (double x = -kSearchBehind; x <= kSearchAhead + 1e-9; x += kSearchStep) {
      for (double y = -kSearchAside; y <= kSearchAside + 1e-9; y += kSearchStep) {
        const Pose candidate = displaced(last_pose(), heading * Eigen::Vector2d(x, y));
        const std::size_t points_near = map_.count_near(points, candidate);
        if (points_near <= best_count) continue;
        best_count = points_near;
        best = candidate;
      }
    }
  }
  return best;
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
  const VerticalStructureMap::Fit fit_there = map_.fit(points, coarse_search(points));
  if (fit_there.evidence <= fit_here.evidence) hypotheses_.clear();
  const Eigen::Vector2d ahead = heading_of(difference(last_pose(), fit_there.T_map_sensor));
  if (fit_there.evidence < kMinEvidenceRatio * fit_here.evidence ||
      !is_distinct(fit_there, ahead, points)) {
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

bool FalseStandstillRecovery::is_distinct(const VerticalStructureMap::Fit& fit,
                                          const Eigen::Vector2d& ahead,
                                          const std::vector<Eigen::Vector3f>& points) const {
  const Pose& pose = fit.T_map_sensor;
  const int evidence_behind =
      map_.evaluate(points, displaced(pose, -kDistinctDistance * ahead)).evidence;
  const int evidence_ahead =
      map_.evaluate(points, displaced(pose, kDistinctDistance * ahead)).evidence;
  return fit.directions >= kMinDirections &&
         fit.evidence > kMinEvidenceRatio * 0.5 * (evidence_behind + evidence_ahead);
}

std::optional<Pose> FalseStandstillRecovery::fit(const SampledPoints& points,
                                                 const MotionState& predicted) {
  const std::vector<Eigen::Vector3f> vertical = sampled_vertical_points_at(points, predicted.twist);
  const VerticalStructureMap::Fit fit = map_.fit(vertical, predicted.T_map_sensor);
  if (is_distinct(fit, heading_of(predicted.twist), vertical)) {
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
