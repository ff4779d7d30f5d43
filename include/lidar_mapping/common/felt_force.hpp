// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// Mean specific force between two instants, as the accelerometer measured it.
struct FeltForce {
  Stamp since = 0;  ///< begin of the time over which the mean is taken
  /// Mean specific force, m/s^2 (+g upward at rest), axes of base_link.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_base_imu = Eigen::Vector3d::Zero();  ///< place of the accelerometer, m
};

}  // namespace lidar_mapping
