// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace lidar_mapping::front_end {

/// Uncertainty of the distance travelled along directions that nothing has observed. Where the
/// points do not constrain a direction, as in a tunnel, the pose follows the believed speed, and
/// the errors of this speed add up. This is a Kalman filter of distance and speed along the
/// unobserved directions. While the speed is not observed, it is modelled as a random walk whose
/// rate is learned from the drive so far. The motion filter of the odometry cannot give this
/// uncertainty, because it takes a pose as known relative to what was last inserted into the map.
class UnobservedTravel {
 public:
  /// Adds a scan that observed all directions, `seconds` after the previous one. `speed` (m/s) has
  /// this variance (m^2/s^2).
  void add_observed(double speed, double variance, double seconds);
  /// Adds a scan that did not observe some directions. `information` (s^2/m^2) is the information
  /// of other sensors about the speed along them.
  void add_unobserved(double information, double seconds);
  /// Discards the knowledge of the speed, because tracking was lost.
  void interrupt();

  /// Standard deviation of the distance travelled since the start, m. It never decreases: the error
  /// of an unobserved section stays in the trajectory.
  double stddev() const { return std::sqrt(travel_variance_); }

 private:
  /// Variance, m^2/s^2: that of a first motion (kInitialSpeedSigma of tracker_state.cpp); chosen.
  static constexpr double kUnknownSpeed = 15.0 * 15.0;

  /// Rate of the random walk of the speed, (m/s)^2 per second: the speed of a car changes by about
  /// 0.8 m/s within four seconds.
  double speed_random_walk_ = 0.16;
  double observed_speed_ = 0.0;  ///< m/s, at the last update of the random walk
  double observed_for_ = -1.0;   ///< s since then; negative if there was none
  double speed_variance_ = kUnknownSpeed;
  double travel_speed_covariance_ = 0.0;  ///< covariance of distance and speed
  double travel_variance_ = 0.0;
};

}  // namespace lidar_mapping::front_end
