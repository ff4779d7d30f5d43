// SPDX-License-Identifier: BSD-3-Clause
#include "motion/coasting.hpp"

namespace lidar_mapping::front_end {
namespace {

// Standard deviations of the unknown accelerations; chosen as of a vehicle that brakes or steers
// hard.
constexpr double kAcceleration = 3.0;         // m/s^2
constexpr double kAngularAcceleration = 1.0;  // rad/s^2
// Chosen: 1 cm and 0.1 degrees per scan at 10 Hz, slower than any driving vehicle.
constexpr double kRestSpeed = 0.1;  // m/s
constexpr double kRestTurn = 0.02;  // rad/s

/// While tracking is lost, the speed decreases to 1/e in this time. Chosen: what was measured a
/// second ago says little about the speed now.
constexpr double kSpeedTimeConstant = 1.0;  // s

bool is_at_rest(const Vector6d& twist) {
  return twist.head<3>().norm() < kRestSpeed && twist.tail<3>().norm() < kRestTurn;
}

}  // namespace

TrackedScan coasted(const TrackedScan& tracked, double seconds) {
  TrackedScan result = tracked;
  const Pose T_tracked_now = moved(Pose::Identity(), tracked.twist, seconds);
  result.T_odom_base = tracked.T_odom_base * T_tracked_now;
  const double half_time_squared = 0.5 * seconds * seconds;
  result.covariance =
      compose_covariance(tracked.covariance, T_tracked_now,
                         diagonal_covariance(half_time_squared * kAcceleration,
                                             half_time_squared * kAngularAcceleration));
  result.acceleration.setZero();
  result.status = {};
  result.status.state = is_at_rest(tracked.twist) ? TrackingState::kDegraded : TrackingState::kLost;
  result.status.repeated = true;
  result.status.probability = 0.0;
  result.status.unobserved_stddev = tracked.status.unobserved_stddev;
  result.status.elevation_shift = tracked.status.elevation_shift;
  result.new_segment = result.provisional = false;
  result.revisions.clear();
  return result;
}

void coast(double seconds, TrackerState& state) {
  state.filter.slow_down(seconds, kSpeedTimeConstant);
  state.covariance = state.filter.covariance();
  state.drift_variance_factor = 1.0;
  state.lost_time += seconds;
}

bool keeps_map(const TrackerState& state, double max_lost_time) {
  return state.motion_known && state.lost_time <= max_lost_time;
}

}  // namespace lidar_mapping::front_end
