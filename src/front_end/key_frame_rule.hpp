// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::front_end {

/// Decides when a scan is different enough from the last key frame to become a key frame itself.
struct KeyFrameRule {
  double distance = 2.0;  ///< m, Euclidean
  double angle = 0.5;     ///< rad, of the whole rotation
  double interval = 0.0;  ///< s; 0 switches it off

  /// The rule with all limits multiplied by this factor.
  KeyFrameRule scaled(double factor) const {
    return {factor * distance, factor * angle, factor * interval};
  }
  /// True if the motion from the last key frame to the present pose reaches one of the limits, or
  /// the time between them the interval.
  bool reached(const Pose& T_last_now, Stamp elapsed) const {
    return motion_reached(T_last_now) || (interval > 0.0 && to_seconds(elapsed) >= interval);
  }
  /// The same without regard to the time.
  bool motion_reached(const Pose& T_last_now) const {
    return T_last_now.translation.norm() >= distance ||
           rotation_angle(T_last_now.rotation) >= angle;
  }
};

}  // namespace lidar_mapping::front_end
