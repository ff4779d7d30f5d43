// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/step_judge.hpp"

#include <optional>
#include <vector>

#include "judgement/match_evidence.hpp"
#include "judgement/reported_covariance.hpp"
#include "matching/degeneracy.hpp"

namespace lidar_mapping::front_end {
namespace {

/// After a gap of this length (s) between scans the sensor may be anywhere, and the map of where it
/// was may fit to where it is. Chosen: as long as tracking may be lost before a new map begins, by
/// the default of max_lost_time. Measured in a simulated tunnel with gaps of 4 and 6 s: matches
/// that were accepted were 6 to 89 m off, though they expected 1 to 7 m.
constexpr double kLongGap = 3.0;

void set_match(const SweepMatcher::Found& found, FrontEndStatus& status) {
  status.converged = found.match.converged;
  status.iterations = found.match.iterations;
  status.fitness = found.match.fitness;
  status.inlier_fraction = found.match.inlier_fraction;
  status.overlap = found.match.overlap;
  status.rescued = found.rescued;
}

/// A map of a single place seems to constrain more directions than it does.
std::vector<Eigen::Vector3d> unobserved_directions(const SweepMatcher::Found& found,
                                                   const MapCoverage& coverage) {
  if (!coverage.is_single_place || !found.degenerate_directions.empty())
    return found.degenerate_directions;
  return degenerate_directions(found.match.pose_hessian, kSinglePlaceFraction);
}

/// Difference between the match and the motion during the last sweep, continued until now.
Vector6d motion_change(const NdtMatch& match, const Pose& last_matched_pose, double seconds) {
  const Pose expected = continued(last_matched_pose, match.state.twist, seconds);
  return difference(expected, match.state.T_map_sensor);
}

/// As the sweep is not smoothed before it is judged, its own covariance is taken as the last one's.
PoseEstimate estimate_at_stamp(const NdtMatch& match, const TrackerState& state, double to_stamp) {
  Matrix12d covariance = reported_covariance(match);
  if (state.smoother.has_smoothed_last_match())
    covariance = without_smoothed_twist(covariance, state.filter.is_rotation_measured());
  return {moved(match.state.T_map_sensor, match.state.twist, to_stamp),
          pose_covariance(covariance, match.state.twist, to_stamp),
          drift_variance_factor(state, match), state.smoother.usual_covariance()};
}

/// How well the motion during the sweep agrees with that of the last one.
void set_motion_evidence(const NdtMatch& match, const TrackerState& state, double since_matched,
                         StepEvidence& evidence) {
  const Vector6d change = motion_change(match, state.last_matched_pose, since_matched);
  evidence.motion_change = change.head<3>().norm();
  evidence.motion_change_angle = change.tail<3>().norm();
  const std::optional<PreviousMatch> last = state.filter.last_match();
  if (!last) return;
  const Vector6d gap = gap_between(*last, match.state);
  evidence.sweep_gap = gap.head<3>().norm();
  evidence.sweep_gap_angle = gap.tail<3>().norm();
  evidence.turn = match.state.twist.tail<3>().norm() * continued_time(last->seconds_before);
}

}  // namespace

void StepJudge::reset() {
  match_judge_.reset();
  doubt_.reset();
}

void StepJudge::advance(double seconds) {
  since_scan_ = seconds;
  origin_.advance(seconds);
}

StepBelief StepJudge::judge(const StepMatch& match, const TrackerState& state,
                            const SweepSampler& sweep, double since_matched,
                            FrontEndStatus& status) {
  const NdtMatch& ndt = match.found.match;
  set_match(match.found, status);
  status.degenerate_directions = unobserved_directions(match.found, state.coverage);
  status.evidence = collect_evidence(match, state, sweep, since_matched);
  status.evidence.degenerate = status.degenerate_directions.empty() ? 0.0 : 1.0;
  status.state = match_judge_.judge(ndt, match.prior);
  if (!is_possible(ndt, state, since_matched)) status.state = TrackingState::kLost;
  const StepBelief belief = evaluate_step(status.evidence, EvidenceSource::kNdt);
  if (state.motion_known && since_scan_ > kLongGap && !belief.is_safe(false))
    status.state = TrackingState::kLost;
  doubt_.apply(belief, status);
  return belief;
}

StepEvidence StepJudge::collect_evidence(const StepMatch& match, const TrackerState& state,
                                         const SweepSampler& sweep, double since_matched) const {
  const NdtMatch& ndt = match.found.match;
  StepEvidence evidence = evidence_of(ndt, match.prior);
  evidence.points = static_cast<double>(sweep.points().size());
  evidence.rescued = match.found.rescued ? 1.0 : 0.0;
  if (state.motion_known && sweep.duration() > 0.0)
    set_motion_evidence(ndt, state, since_matched, evidence);
  origin_.set_step_to(estimate_at_stamp(ndt, state, -sweep.reference()), evidence);
  return evidence;
}

/// Uses the motion since the last match, not the motion during the sweep, which does not show a
/// jump of the pose. In a map of one scan the motion is not known yet, so it cannot be checked.
bool StepJudge::is_possible(const NdtMatch& match, const TrackerState& state,
                            double since_matched) const {
  const Pose T_last_now = state.last_matched_pose.inverse() * match.state.T_map_sensor;
  return !state.motion_known || match_judge_.is_possible_motion(T_last_now, since_matched);
}

}  // namespace lidar_mapping::front_end
