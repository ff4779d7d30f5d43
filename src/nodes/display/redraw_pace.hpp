// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace lidar_mapping::ros_border {

/// When a display is drawn again whose drawing takes longer as the drive grows: at most once a
/// second, and so seldom that drawing takes at most kShare of the time. Times are in s.
class RedrawPace {
 public:
  static constexpr double kInterval = 1.0;  // s; chosen: what a person sees as live
  /// Of one core. Chosen: up to some 50 km, drawing takes place every second, for 200 km (measured:
  /// 0.5 s) every ten seconds.
  static constexpr double kShare = 0.05;

  bool is_due(double now) const { return now >= next_; }
  void drawn(double begin, double end) {
    next_ = begin + std::max(kInterval, (end - begin) / kShare);
  }

 private:
  double next_ = 0.0;
};

}  // namespace lidar_mapping::ros_border
