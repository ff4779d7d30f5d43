// SPDX-License-Identifier: BSD-3-Clause
#include "start/map_initialization.hpp"

#include "judgement/reported_covariance.hpp"
#include "matching/degeneracy.hpp"
#include "matching/search_starts.hpp"

namespace lidar_mapping::front_end {
namespace {

// The first scans are matched again under two conditions. The vehicle begins faster than this
// speed. Chosen: with a slower one key frames would wait too long for the map to grow. And the
// fraction of the second scan's points that find a plane in the map of the first scan, including
// the points between its rings, is smaller than this. Measured: with 64 rings the map is good
// enough (0.56 to 0.58 in simulated towns; 0.51 with the rings of an OS1, 0.26 to 0.37 with 16).
constexpr double kMinSpeed = 3.0;  // m/s
constexpr double kMinOverlap = 0.55;
/// Number of rounds in which the first scan is deskewed and the second one is matched with it.
/// Chosen: bounds the time; rounds end earlier when the twist does not change any more.
constexpr int kStartRounds = 3;
// Chosen: twists that differ by less move no point by more than the sensor's noise (by 2 mm, and by
// 1 cm at 100 m, in a sweep of 0.1 s).
constexpr double kMaxSpeedDifference = 0.02;  // m/s
constexpr double kMaxRateDifference = 1e-3;   // rad/s

bool is_same_motion(const Vector6d& a, const Vector6d& b) {
  const Vector6d d = a - b;
  return d.head<3>().norm() < kMaxSpeedDifference && d.tail<3>().norm() < kMaxRateDifference;
}

Revision revision_of(const SweepMatcher::Found& found, double reference) {
  const MotionState& state = found.match.state;
  return {moved(state.T_map_sensor, state.twist, -reference),
          pose_covariance(reported_covariance(found.match), state.twist, -reference),
          initial_drift_variance_factor(found.match),
          state.twist,
          Vector6d::Zero(),
          found.degenerate_directions};
}

}  // namespace

void MapInitialization::start(const Pose& T_odom_base) {
  start_pose_ = T_odom_base;
  delayed_.start();
}

void MapInitialization::set_first_scan(const SampledPoints& points,
                                       const SampledPoints& between_rings, bool have_times,
                                       double reference) {
  first_points_ = points;
  first_points_between_rings_ = between_rings;
  first_has_times_ = have_times;
  first_reference_ = reference;
}

SweepMatcher::Found MapInitialization::match_second_scan(const NdtPoints& points,
                                                         const MotionBelief& prediction,
                                                         double seconds, SweepMatcher& matcher,
                                                         LocalMap& map) const {
  SweepMatcher::Found found;
  std::vector<MotionState> starts = starts_at_speed(start_pose_, seconds + first_reference_);
  starts.push_back(prediction.state);
  Vector6d deskewing_twist = Vector6d::Zero();
  const auto deskew_first = [&](const Vector6d& twist) {
    if (!first_has_times_ || is_same_motion(twist, deskewing_twist)) return false;
    deskewing_twist = twist;
    map.clear();
    map.insert(first_points_, first_state(twist));
    map.insert(first_points_between_rings_, first_state(twist));
    return true;
  };
  deskew_first(prediction.state.twist);
  found.match = matcher.search(points, map, prediction, starts);
  for (int round = 0; round < kStartRounds && deskew_first(found.match.state.twist); ++round) {
    found.match = matcher.refine(points, map, prediction, found.match.state);
  }
  found.degenerate_directions = degenerate_directions(found.match.pose_hessian);
  return found;
}

bool MapInitialization::replaces_first_scan(const StepBelief& belief) {
  if (first_scan_replaced_ || belief.is_safe(false)) return false;
  first_scan_replaced_ = true;
  return true;
}

void MapInitialization::set_motion(const NdtMatch& match) {
  first_scan_replaced_ = false;
  if (!delayed_.is_active()) return;
  const Vector6d& twist = match.state.twist;
  delayed_.set_first_state(first_state(twist));
  if (twist.head<3>().norm() < kMinSpeed || match.overlap > kMinOverlap) delayed_.stop();
}

void MapInitialization::add(Stamp stamp, const SweepSampler& sweep, const MotionFilter& filter) {
  if (!delayed_.is_active()) return;
  delayed_.add({stamp, sweep.reference(), sweep.points(), filter.state(), filter.covariance(), {}});
}

std::vector<Revision> MapInitialization::rematch_first_scans(const MotionFilter& filter,
                                                             const MatchJudge& judge,
                                                             LocalMap& map) {
  std::vector<Revision> revisions;
  if (!delayed_.is_active() || !delayed_.rematch(filter, judge, map)) return revisions;
  const auto& found = delayed_.results();
  for (std::size_t i = 0; i < found.size(); ++i) {
    revisions.push_back(revision_of(found[i], delayed_.scans()[i].reference));
  }
  delayed_.stop();
  return revisions;
}

}  // namespace lidar_mapping::front_end
