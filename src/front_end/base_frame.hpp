// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"

namespace lidar_mapping::front_end {

/// Gives a rotation during a sweep in other axes: those that `R_new_old` turns its own into.
void turn_axes(const Eigen::Quaterniond& R_new_old, UnevenTurning& turning);

/// Converts between base_link, which all other parts of the package use, and the LiDAR's own frame,
/// in which the odometry works. The odometry's origin is the first pose of the LiDAR. The choice of
/// base_link has no influence on the odometry.
class BaseFrame {
 public:
  /// Pose of the LiDAR on the vehicle.
  void set_sensor_pose(const Pose& T_base_sensor) { T_base_sensor_ = T_base_sensor; }
  /// Sets the pose of base_link in odom at which the odometry begins.
  void set_start(const Pose& T_odom_base) { T_odom_first_ = T_odom_base * T_base_sensor_; }

  /// Converts the motion of the vehicle, as other sensors measured it, to the motion of the LiDAR.
  /// If the angular velocity was not measured, the velocity is transferred from base_link to the
  /// LiDAR with `turning` (rad/s, in the LiDAR's axes).
  MotionPrior of_sensor(const MotionPrior& prior, const Eigen::Vector3d& turning) const;
  /// The inverse conversion: from the LiDAR's results to those of base_link.
  FrontEndResult of_base(FrontEndResult result) const;
  std::vector<FrontEndResult> of_base(std::vector<FrontEndResult> results) const;
  /// Transforms points from the first frame of the LiDAR to odom.
  PointCloud in_odom(const PointCloud& cloud) const { return transformed(cloud, T_odom_first_); }

 private:
  Pose base_in_odom(const Pose& T_first_sensor) const;
  void to_base(std::vector<Eigen::Vector3d>& directions) const;
  KeyFrame of_base(KeyFrame key_frame) const;

  Pose T_base_sensor_;
  Pose T_odom_first_;
};

}  // namespace lidar_mapping::front_end
