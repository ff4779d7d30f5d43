// SPDX-License-Identifier: BSD-3-Clause
// Where a map starts and ends: at the first scan, if the second scan does not fit to the first one,
// and after tracking was lost.
#include "judgement/reported_covariance.hpp"
#include "motion/coasting.hpp"
#include "tracking/ndt_tracker.hpp"

namespace lidar_mapping::front_end {
namespace {

/// A map does not start with fewer points. Chosen: they are ten planes of five points at most.
constexpr std::size_t kMinPoints = 50;

}  // namespace

void NdtTracker::start(const Scan& scan, FrontEndStatus& status) {
  start_map(scan, Pose::Identity());
  status.converged = has_enough_points();
  status.state = has_enough_points() ? TrackingState::kTracking : TrackingState::kLost;
}

bool NdtTracker::has_enough_points() const { return sweep_.points().size() >= kMinPoints; }

/// The points are stored until the motion during the scan is known.
void NdtTracker::start_map(const Scan& scan, const Pose& T_odom_base) {
  start_motion(T_odom_base, sweep_.reference(), state_);
  mapper_.start_map(scan, T_odom_base, sweep_, state_.map);
  if (!has_enough_points()) return;
  has_begun_ = true;
  initialization_.start(T_odom_base);
  initialization_.add(scan.stamp, sweep_, state_.filter);
  insert(scan);
  initialization_.set_first_scan(sweep_.sample_dense(scan),
                                 mapper_.first_points_between_rings(scan, sweep_),
                                 scan.cloud.has_times(), sweep_.reference());
}

void NdtTracker::discard_map() {
  state_.discard_map();
  mapper_.interrupt();
  judge_.reset();
  initialization_.finalize();
  false_standstill_.reset();
  unobserved_travel_.interrupt();
}

void NdtTracker::replace_first_scan(const Scan& scan, const StepMatch& match,
                                    FrontEndStatus& status) {
  const MotionState& matched = match.found.match.state;
  const Matrix12d covariance = reported_covariance(match.found.match) +
                               doubt_covariance(matched, match.prior, status.probability);
  // Its pose comes from a match that is not certain.
  if (claims_pose(status.state)) status.state = TrackingState::kDoubtful;
  discard_map();
  start_map(scan, moved(matched.T_map_sensor, matched.twist, -sweep_.reference()));
  initialization_.finalize();
  state_.covariance = covariance;
}

void NdtTracker::lose(const Step& step, TrackedScan& result) {
  predict(step);
  result.status.state = TrackingState::kLost;
  recover(step, result);
}

void NdtTracker::recover(const Step& step, TrackedScan& result) {
  initialization_.finalize();
  unobserved_travel_.interrupt();
  coast(step.seconds, state_);
  const bool keeps = !state_.map.empty() && keeps_map(state_, max_lost_time_);
  if (keeps || !has_enough_points()) return;
  const MotionState& predicted = state_.filter.state();
  const Pose at_stamp = moved(predicted.T_map_sensor, predicted.twist, -sweep_.reference());
  discard_map();
  start_map(step.scan, at_stamp);
  // The pose is still a prediction, so the state remains lost.
  result.status.converged = true;
  result.new_segment = true;
}

void NdtTracker::restart() {
  discard_map();
  has_begun_ = false;
}

}  // namespace lidar_mapping::front_end
