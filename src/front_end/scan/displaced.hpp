// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// The pose, moved along its own x and y (m) and turned about its own z (rad).
inline Pose displaced(const Pose& pose, const Eigen::Vector2d& by, double yaw = 0.0) {
  Vector6d d = Vector6d::Zero();
  d.head<2>() = by;
  d[5] = yaw;
  return perturbed(pose, d);
}

}  // namespace lidar_mapping::front_end
