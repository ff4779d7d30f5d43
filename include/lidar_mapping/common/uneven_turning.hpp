// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping {

/// Rotation during a sweep by the gyro, without its mean rate w: exp(-w t) R(t) at equal steps of
/// time (s, relative to the scan's stamp; R(t) from the axes at time t to those at the stamp).
struct UnevenTurning {
  double begin = 0.0;  ///< time of the first knot, s
  double step = 0.0;   ///< from knot to knot, s; positive if there are knots
  std::vector<Eigen::Quaterniond> R_stamp_knot;  ///< exp(-w t) R(t) at the knots

  /// Slerp between the knots (of which there has to be one) at a time in s; held beyond the ends.
  Eigen::Quaterniond at(double time) const;
  /// The largest angle of the sweep over its duration, rad/s.
  double mean_rate() const;
};

/// The points as they were measured, before `turning` was removed from their sweep, in the same
/// axes as `turning`. A cloud without times is returned as it is.
PointCloud put_back(const UnevenTurning& turning, PointCloud cloud);

}  // namespace lidar_mapping
