// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"

namespace lidar_mapping::front_end {

/// What other sensors say about the motion at the scan's stamp; all optional.
struct MotionPrior {
  std::optional<Eigen::Vector3d> angular_velocity;  ///< rad/s, axes of base_link
  std::optional<Eigen::Vector3d> linear_velocity;   ///< m/s, of base_link in its axes
  /// rad/s, axes of base_link: how the vehicle turned where linear_velocity was measured. The way
  /// from there to base_link was reckoned with it, and so is the way on to the LiDAR; without it
  /// angular_velocity stands in.
  std::optional<Eigen::Vector3d> velocity_turning;
  /// What the gyro has taken out of the scan beside that: it is put back where the gyro is wrong.
  std::optional<UnevenTurning> uneven_turning = std::nullopt;
  /// By the accelerometer since the scan before.
  std::optional<FeltForce> felt = std::nullopt;
  /// Pose of base_link by an odometry outside; used instead of matching with `odometry: external`.
  std::optional<Pose> T_external_base;
  /// Pose of the first scan in odom; used once.
  std::optional<Pose> T_odom_base_initial;
};

}  // namespace lidar_mapping::front_end
