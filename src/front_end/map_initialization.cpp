// SPDX-License-Identifier: BSD-3-Clause
#include "map_initialization.hpp"

#include "degeneracy.hpp"
#include "reported_covariance.hpp"
#include "search_starts.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Until the sensor is so far from where the map began (in voxels), it is a map of one place.
constexpr double kOnePlace = 10.0;
/// So many scans make a young map.
constexpr int kYoungScans = 12;
// The first scans are looked at again if the vehicle begins faster than that, as key frames of a
// slower one would wait too long for the map to grow, and if fewer of the points of the second scan
// find a plane in the map of the first, those between its rings included: with 64 rings it is good
// enough (0.56 to 0.58 in simulated towns; 0.51 with the rings of an OS1, 0.26 to 0.37 with 16).
constexpr double kAtSpeed = 3.0;  // m/s
constexpr double kEnoughPlanes = 0.55;
/// Rounds of deskewing the first scan and matching the second one with it.
constexpr int kStartRounds = 3;
// Twists that differ by less move no point by more than the sensor's noise.
constexpr double kSameSpeed = 0.02;  // m/s
constexpr double kSameRate = 1e-3;   // rad/s

bool is_same_motion(const Vector6d& a, const Vector6d& b) {
  const Vector6d d = a - b;
  return d.head<3>().norm() < kSameSpeed && d.tail<3>().norm() < kSameRate;
}

Revision revision_of(const SweepMatcher::Found& found, double reference) {
  const MotionState& state = found.match.state;
  return {moved(state.T_map_sensor, state.twist, -reference),
          pose_covariance(reported_covariance(found.match), state.twist, -reference),
          variance_in_young_map(found.match),
          state.twist,
          Vector6d::Zero(),
          found.degenerate_directions};
}

}  // namespace

void MapInitialization::forget() {
  first_scans_.end();
  inserted_scans_ = 0;
  one_place_ = true;
  motion_known_ = false;
}

void MapInitialization::begin(const Pose& T_odom_base) {
  start_ = T_odom_base;
  first_scans_.begin();
}

void MapInitialization::keep_first(const SampledPoints& points, const SampledPoints& between,
                                   bool have_times, double reference) {
  first_ = points;
  between_first_ = between;
  first_has_times_ = have_times;
  first_reference_ = reference;
}

SweepMatcher::Found MapInitialization::find_motion(const registration::NdtPoints& points,
                                                   const registration::MotionBelief& prediction,
                                                   double seconds, SweepMatcher& matcher,
                                                   LocalMap& map) const {
  SweepMatcher::Found found;
  std::vector<MotionState> starts = starts_at_speed(start_, seconds + first_reference_);
  starts.push_back(prediction.state);
  Vector6d deskewed_with = Vector6d::Zero();
  const auto deskew_first = [&](const Vector6d& twist) {
    if (!first_has_times_ || is_same_motion(twist, deskewed_with)) return false;
    deskewed_with = twist;
    map.clear();
    map.insert(first_, first_state(twist));
    map.insert(between_first_, first_state(twist));
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

bool MapInitialization::gives_way(const StepBelief& belief) {
  if (motion_known_ || gave_way_ || belief.is_safe(false)) return false;
  gave_way_ = true;
  return true;
}

void MapInitialization::know_motion(const registration::NdtMatch& match) {
  motion_known_ = true;
  gave_way_ = false;
  if (!first_scans_.is_open()) return;
  const Vector6d& twist = match.state.twist;
  first_scans_.set_first(first_state(twist));
  if (twist.head<3>().norm() < kAtSpeed || match.overlap > kEnoughPlanes) first_scans_.end();
}

std::vector<Revision> MapInitialization::look_again(const MotionFilter& filter,
                                                    const MatchJudge& judge, LocalMap& map) {
  std::vector<Revision> revisions;
  if (!first_scans_.is_open() || !first_scans_.look_again(filter, judge, map)) return revisions;
  const auto& found = first_scans_.found();
  for (std::size_t i = 0; i < found.size(); ++i) {
    revisions.push_back(revision_of(found[i], first_scans_.scans()[i].reference));
  }
  first_scans_.end();
  return revisions;
}

bool MapInitialization::is_young() const { return inserted_scans_ <= kYoungScans; }

void MapInitialization::set_inserted(const SampledPoints& points, const Eigen::Vector3d& p_odom,
                                     double voxel_size) {
  first_scans_.set_inserted(points);
  ++inserted_scans_;
  if ((p_odom - start_.translation).norm() > kOnePlace * voxel_size) one_place_ = false;
}

}  // namespace lidar_mapping::front_end
