// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/units.hpp"

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

/// The pose of x y z (m) and roll pitch yaw (degrees), as people write it in files and parameters;
/// not turned where the three angles are left out.
inline Pose pose_from_degrees(const std::vector<double>& numbers) {
  Pose pose;
  pose.translation = {numbers[0], numbers[1], numbers[2]};
  if (numbers.size() < 6) return pose;
  pose.rotation =
      rotation_from_rpy(numbers[3] * kRadPerDeg, numbers[4] * kRadPerDeg, numbers[5] * kRadPerDeg);
  return pose;
}

}  // namespace lidar_mapping
