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

/// What the status of a scan tells of the drive so far, not of the match of that scan.
FrontEndStatus status_of_drive(const FrontEndStatus& before) {
  FrontEndStatus status;
  status.map_points_dropped = before.map_points_dropped;
  status.unobserved_stddev = before.unobserved_stddev;
  status.elevation_shift = before.elevation_shift;
  status.stamp_jitter = before.stamp_jitter;
  status.sweep_times = before.sweep_times;
  status.gyro_distrusted = before.gyro_distrusted;
  status.velocity_distrusted = before.velocity_distrusted;
  status.vertical_ride_distance = before.vertical_ride_distance;
  return status;
}

}  // namespace

TrackedScan coasted(const TrackedScan& tracked, double seconds) {
  TrackedScan result = tracked;
  const Pose T_tracked_now = continued(Pose::Identity(), tracked.twist, seconds);
  result.T_odom_base = tracked.T_odom_base * T_tracked_now;
  const double half_time_squared = 0.5 * seconds * seconds;
  result.covariance =
      compose_covariance(tracked.covariance, T_tracked_now,
                         diagonal_covariance(half_time_squared * kAcceleration,
                                             half_time_squared * kAngularAcceleration));
  result.acceleration.setZero();
  result.status = status_of_drive(tracked.status);
  result.status.state = is_at_rest(tracked.twist) ? TrackingState::kDegraded : TrackingState::kLost;
  result.status.repeated = true;
  result.status.probability = 0.0;
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
