// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/sweep_times.hpp"

namespace lidar_mapping::front_end {

/// How the points of a scan were changed before they were matched, where they were found wrong.
struct PointCorrection {
  /// The gyro's correction (MotionPrior::uneven_turning) was undone: it is distrusted, or was made
  /// by wrong times.
  bool undo_gyro = false;
  SweepTimesRule times;          ///< by which the points got their times
  double elevation_shift = 0.0;  ///< angle by which the points were rotated upwards, rad
};

}  // namespace lidar_mapping::front_end
