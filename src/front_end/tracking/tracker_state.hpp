// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/front_end_config.hpp"

#include "local_map/local_map.hpp"
#include "matching/sweep_matcher.hpp"
#include "motion/motion_filter.hpp"
#include "motion/sweep_smoother.hpp"
#include "scan/sweep_sampler.hpp"
#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// How complete a local map is.
struct MapCoverage {
  int inserted_scans = 0;
  /// True while all scans of the map were taken at about the same place.
  bool is_single_place = true;
};

/// What the sequential NDT carries from scan to scan: the local map, and the motion in it. Poses
/// and twists are those in the middle of a sweep.
struct TrackerState {
  explicit TrackerState(const FrontEndConfig& config);

  /// Discards the map. The motion is kept: a map that starts afterwards replaces it.
  void discard_map();

  LocalMap map;
  MapCoverage coverage;
  MotionFilter filter;
  SweepSmoother smoother;
  /// False until a second scan was matched: before that, the twist is only assumed.
  bool motion_known = false;
  /// The reported covariance of pose and twist. The filter's own covariance is too large after a
  /// match: see reported_covariance().
  Matrix12d covariance = Matrix12d::Identity();
  double drift_variance_factor = 1.0;  ///< TrackedScan::drift_variance_factor
  Pose last_matched_pose;              ///< pose of the scan last matched
  double lost_time = 0.0;              ///< s since the last match
};

/// The drift variance factor of a match with the map of this state.
double drift_variance_factor(const TrackerState& state, const NdtMatch& match);

/// Sets the motion at the first scan of a map: the pose at the scan's stamp is known, the twist is
/// not. `reference` is the time from the stamp to the middle of the sweep, s.
void start_motion(const Pose& T_odom_base, double reference, TrackerState& state);

/// Adopts the motion that was matched in a sweep of `duration` seconds.
void correct_motion(const SweepMatcher::Found& found, double duration, TrackerState& state);

/// Writes pose, twist and acceleration at the stamp of the sweep, with their uncertainty, into the
/// result.
void set_motion_at_stamp(const TrackerState& state, const SweepSampler& sweep, TrackedScan& result);

}  // namespace lidar_mapping::front_end
