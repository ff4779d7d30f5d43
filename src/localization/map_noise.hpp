// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::localization {

/// How far off the map's surfaces are from place to place, learnt from how well two ways of moving
/// agree: from match to match in the map, and by odometry, which knows nothing of the map (Mehra
/// 1970, "On the identification of variances and adaptive Kalman filtering").
class MapNoise {
 public:
  /// A pose that was matched with the map.
  void add_match(const Pose& T_map_base);
  /// The motion by odometry since the last call.
  void move(const Pose& T_previous_base);
  /// Odometry was interrupted or the place was given up: the distance starts again.
  void interrupt() { matches_.clear(); }

  double stddev() const;        ///< of each coordinate, m
  double stddev_angle() const;  ///< about each axis, rad

 private:
  struct Match {
    Pose T_map_base;
    Pose T_odom_base;
    double distance;  ///< m, driven until then
  };

  void learn(const Match& before, const Match& now);

  std::deque<Match> matches_;
  Pose T_odom_base_;
  double distance_ = 0.0;                                  ///< m
  double weight_ = kAssumedWeight;                         ///< comparisons in the means
  double variance_ = kAssumed * kAssumed;                  ///< m^2
  double variance_angle_ = kAssumedAngle * kAssumedAngle;  ///< rad^2

  /// What is assumed until enough has been driven. Chosen: the range noise of a LiDAR; m, and rad
  /// (0.05 degrees).
  static constexpr double kAssumed = 0.02;
  static constexpr double kAssumedAngle = 0.0009;
  /// Comparisons that this counts for. Chosen: the least.
  static constexpr double kAssumedWeight = 1.0;
};

}  // namespace lidar_mapping::localization
