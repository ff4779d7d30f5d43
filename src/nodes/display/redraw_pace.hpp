// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace lidar_mapping::ros_border {

/// When a display is drawn again whose drawing takes longer as the drive grows: at most once a
/// second, and so seldom that drawing takes at most kShare of the time. Times are in s.
class RedrawPace {
 public:
  static constexpr double kInterval = 1.0;  // s; chosen: what a person sees as live
  /// Of one core. Chosen: 200 km are drawn every few seconds then, 20 km nearly every second.
  static constexpr double kShare = 0.02;

  bool is_due(double now) const { return now >= next_; }
  void drawn(double begin, double end) {
    next_ = begin + std::max(kInterval, (end - begin) / kShare);
  }

 private:
  double next_ = 0.0;
};

}  // namespace lidar_mapping::ros_border
