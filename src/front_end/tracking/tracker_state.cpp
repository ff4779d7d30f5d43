// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/tracker_state.hpp"

#include <Eigen/LU>

#include "judgement/reported_covariance.hpp"
#include "matching/degeneracy.hpp"

namespace lidar_mapping::front_end {
namespace {

// Standard deviations of the motion before the second scan. Chosen: any vehicle may be moving
// already, as a car in town (54 km/h) or a person who turns.
constexpr double kInitialSpeedSigma = 15.0;  // m/s
constexpr double kInitialRateSigma = 1.0;    // rad/s

/// Up to this number of scans, the drift variance is increased: half of kWantedInsertions of
/// delayed_initialization.cpp, with which planes are upright.
constexpr int kFewScans = 12;

}  // namespace

TrackerState::TrackerState(const FrontEndConfig& config)
    : map(config.voxel_size, config.local_map_radius),
      filter(config.acceleration_sigma, config.angular_acceleration_sigma) {}

void TrackerState::discard_map() {
  map.clear();
  coverage = {};
  motion_known = false;
  lost_time = 0.0;
}

double drift_variance_factor(const TrackerState& state, const NdtMatch& match) {
  return state.coverage.inserted_scans <= kFewScans ? initial_drift_variance_factor(match) : 1.0;
}

void start_motion(const Pose& T_odom_base, double reference, TrackerState& state) {
  state.last_matched_pose = T_odom_base;
  state.filter.reset(T_odom_base, kInitialSpeedSigma, kInitialRateSigma);
  state.smoother.reset();
  state.filter.predict(reference);
  state.covariance = state.filter.covariance();
  state.drift_variance_factor = 1.0;
}

void correct_motion(const SweepMatcher::Found& found, double duration, TrackerState& state) {
  const NdtMatch& match = found.match;
  state.filter.correct(match.state, match.information.inverse(),
                       projection_orthogonal_to(found.degenerate_directions));
  state.covariance = reported_covariance(match);
  state.smoother.add(found, state.filter, duration);
  state.drift_variance_factor = drift_variance_factor(state, match);
  state.last_matched_pose = match.state.T_map_sensor;
  state.lost_time = 0.0;
}

void set_motion_at_stamp(const TrackerState& state, const SweepSampler& sweep,
                         TrackedScan& result) {
  const double to_stamp = -sweep.reference();
  const MotionFilter& filter = state.filter;
  const MotionAtStamp motion = state.smoother.motion_at(to_stamp, filter, sweep.duration());
  result.T_odom_base = motion.state.T_map_sensor;
  result.twist = motion.state.twist;
  result.acceleration = motion.acceleration;
  const Matrix12d covariance =
      state.smoother.is_smoothed(filter)
          ? without_smoothed_twist(state.covariance, filter.is_rotation_measured())
          : state.covariance;
  result.covariance = pose_covariance(covariance, filter.state().twist, to_stamp);
  result.sweep_covariance = motion.covariance;
  result.drift_variance_factor = state.drift_variance_factor;
  result.motion_known = state.motion_known;
}

}  // namespace lidar_mapping::front_end
