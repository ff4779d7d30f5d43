// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"

namespace lidar_mapping::front_end {

/// What is known about a scan beside its points: the motion at its stamp as other sensors measured
/// it, and what preprocessing did to the points. All fields are optional.
struct MotionPrior {
  /// rad/s, axes of base_link: the mean over the sweep if the points have times, else at the stamp.
  std::optional<Eigen::Vector3d> angular_velocity;
  std::optional<Eigen::Vector3d> linear_velocity;  ///< m/s, of base_link in its axes
  /// Angular velocity (rad/s, axes of base_link) that was used to transfer linear_velocity from its
  /// sensor to base_link. The same value has to be used to transfer it to the LiDAR. Without it
  /// angular_velocity is used.
  std::optional<Eigen::Vector3d> velocity_turning;
  /// The non-uniform rotation that was removed from the scan by the gyro. The front end adds it
  /// again if it finds the gyro wrong.
  std::optional<UnevenTurning> uneven_turning = std::nullopt;
  /// cloud_fingerprint() of the points as the driver sent them. Without it that of the scan counts,
  /// which tells nothing if measured motion was removed from the scan.
  std::optional<std::uint64_t> fingerprint = std::nullopt;
  /// Mean specific force by the accelerometer since the previous scan.
  std::optional<FeltForce> felt = std::nullopt;
  /// Pose of base_link by an external odometry; it replaces matching with `odometry: external`.
  std::optional<Pose> T_external_base;
  /// Pose of the first scan in odom; used only once.
  std::optional<Pose> T_odom_base_initial;
};

}  // namespace lidar_mapping::front_end
