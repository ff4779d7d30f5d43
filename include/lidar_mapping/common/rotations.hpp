// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace lidar_mapping {

/// Rotation about the z axis, rad.
inline Eigen::Quaterniond rotation_about_z(double yaw) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

/// Rotation by roll, pitch and yaw about the fixed axes x, y and z, in this order; rad.
inline Eigen::Quaterniond rotation_from_rpy(double roll, double pitch, double yaw) {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

}  // namespace lidar_mapping
