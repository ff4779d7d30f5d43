// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::simulation {

/// Pose of base_link in map and its derivatives at an instant.
struct MotionState {
  Pose T_map_base;
  Eigen::Vector3d velocity_map = Eigen::Vector3d::Zero();               ///< m/s
  Eigen::Vector3d acceleration_map = Eigen::Vector3d::Zero();           ///< m/s^2
  Eigen::Vector3d angular_velocity_base = Eigen::Vector3d::Zero();      ///< rad/s
  Eigen::Vector3d angular_acceleration_base = Eigen::Vector3d::Zero();  ///< rad/s^2

  /// The same of a frame that is fixed to base_link: derivatives of its origin in map, rates in its
  /// own axes.
  MotionState of_frame(const Pose& T_base_frame) const;
};

/// An exact motion: a uniform B-spline of degree five over time for x, y, z, yaw, pitch and roll of
/// base_link in map. All derivatives up to the fourth are continuous and exact.
class SmoothTrajectory {
 public:
  /// `control` holds (x, y, z, yaw, pitch, roll) every `step_s` seconds, yaw unwrapped; the curve
  /// follows them closely, without touching them. At least seven.
  SmoothTrajectory(Stamp begin, double step_s, std::vector<Vector6d> control);

  Stamp begin() const { return begin_; }
  Stamp end() const { return end_; }
  /// T_map_base. Throws InputError outside [begin, end].
  Pose pose(Stamp stamp) const;
  MotionState state(Stamp stamp) const;
  /// Length of the way of base_link's origin between two stamps, m.
  double length(Stamp from, Stamp to) const;

 private:
  Vector6d evaluate(Stamp stamp, int derivative) const;

  Stamp begin_;
  Stamp end_;
  double step_s_;
  std::vector<Vector6d> control_;
};

}  // namespace lidar_mapping::simulation
