// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"

namespace lidar_mapping::front_end {

/// The border between the odometry, which knows the LiDAR's own frame alone and where that was
/// first, and base_link, of which all others speak. What base_link is decides nothing behind it.
class BaseFrame {
 public:
  /// Where the LiDAR sits on the vehicle.
  void set_sensor_pose(const Pose& T_base_sensor) { T_base_sensor_ = T_base_sensor; }
  /// The LiDAR is where its odometry begins, and base_link here in odom.
  void set_start(const Pose& T_odom_base) { T_odom_first_ = T_odom_base * T_base_sensor_; }

  /// What others measured of the vehicle, as that of the LiDAR. Where nobody measured the turning,
  /// the velocity goes from base_link to the LiDAR by `turning` (rad/s, the LiDAR's axes).
  MotionPrior of_sensor(const MotionPrior& prior, const Eigen::Vector3d& turning) const;
  /// The other way: what is known of the LiDAR, as that of base_link.
  FrontEndResult of_base(FrontEndResult result) const;
  std::vector<FrontEndResult> of_base(std::vector<FrontEndResult> results) const;
  /// Points in the frame where the LiDAR was first.
  PointCloud in_odom(const PointCloud& cloud) const { return transformed(cloud, T_odom_first_); }

 private:
  Pose base_in_odom(const Pose& T_first_sensor) const;
  void to_base(std::vector<Eigen::Vector3d>& directions) const;
  KeyFrame of_base(KeyFrame key_frame) const;

  Pose T_base_sensor_;
  Pose T_odom_first_;
};

}  // namespace lidar_mapping::front_end
