#pragma once

#include <optional>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"

namespace lidar_mapping::front_end {

/// What other sensors say about the motion at the scan's stamp; all optional.
struct MotionPrior {
  std::optional<Eigen::Vector3d> angular_velocity;  ///< rad/s, axes of base_link
  std::optional<Eigen::Vector3d> linear_velocity;   ///< m/s, axes of base_link
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
