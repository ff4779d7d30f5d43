// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace lidar_mapping::front_end {

/// How far off the way may be because nothing has observed it. Where the points leave a direction
/// open, as in a tunnel, the pose follows the speed that is believed, and errors of that speed add
/// up. This is a Kalman filter of way and speed along the open directions: unseen, the speed
/// changes as at random, as fast as it has done in the drive so far. The filter of the odometry
/// cannot tell, as it counts a pose as known against what was last put into the map.
class UnobservedTravel {
 public:
  /// A scan that observed all directions `seconds` after the one before: the speed is `speed` (m/s)
  /// with this variance (m^2/s^2).
  void add_observed(double speed, double variance, double seconds);
  /// One that left directions open; `information` (s^2/m^2) is what other sensors said of the speed
  /// along them.
  void add_unobserved(double information, double seconds);
  /// What is known of the speed is no more: the drive was lost.
  void interrupt();

  /// Standard deviation of the way since the beginning, m. It never falls: what was driven blindly
  /// stays as wrong as it is.
  double stddev() const { return std::sqrt(travel_variance_); }

 private:
  static constexpr double kUnknownSpeed = 15.0 * 15.0;  // m^2/s^2

  /// (m/s)^2 per second: within four seconds a car's speed changes by some 0.8 m/s.
  double speed_random_walk_ = 0.16;
  double observed_speed_ = 0.0;  ///< m/s, when the walk was last looked at
  double observed_for_ = -1.0;   ///< s since then; negative: not begun
  double speed_variance_ = kUnknownSpeed;
  double travel_speed_covariance_ = 0.0;  ///< of way and speed
  double travel_variance_ = 0.0;
};

}  // namespace lidar_mapping::front_end
