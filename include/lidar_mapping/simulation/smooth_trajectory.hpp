// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::simulation {

/// Pose of base_link in the map frame and its derivatives at an instant.
struct MotionState {
  Pose T_map_base;                                             ///< Pose at the instant.
  Eigen::Vector3d velocity_map = Eigen::Vector3d::Zero();      ///< Velocity in map axes, m/s.
  Eigen::Vector3d acceleration_map = Eigen::Vector3d::Zero();  ///< Acceleration in map axes, m/s^2.
  /// Angular velocity in the axes of base_link, rad/s.
  Eigen::Vector3d angular_velocity_base = Eigen::Vector3d::Zero();
  /// Its derivative, rad/s^2.
  Eigen::Vector3d angular_acceleration_base = Eigen::Vector3d::Zero();

  /// The motion of another frame that is fixed to base_link: derivatives of its origin in the map
  /// frame, rates in its own axes.
  MotionState of_frame(const Pose& T_base_frame) const;
};

/// An exact motion: a uniform B-spline of degree five over time for x, y, z, yaw, pitch and roll of
/// base_link in the map frame. All derivatives up to the fourth are continuous and exact.
class SmoothTrajectory {
 public:
  /// `control` holds (x, y, z, yaw, pitch, roll) every `step_s` seconds in m and rad, with
  /// unwrapped yaw. The curve is close to these points but does not pass through them. Throws
  /// InputError for fewer than seven points.
  SmoothTrajectory(Stamp begin, double step_s, std::vector<Vector6d> control);

  /// Moves the motion to a later time, by `interval` ns.
  void delay(Stamp interval) {
    begin_ += interval;
    end_ += interval;
  }

  /// First instant, ns.
  Stamp begin() const { return begin_; }
  /// Last instant, ns.
  Stamp end() const { return end_; }
  /// T_map_base. Throws InputError outside [begin, end].
  Pose pose(Stamp stamp) const;
  /// Pose and derivatives. Throws InputError outside [begin, end].
  MotionState state(Stamp stamp) const;
  /// Path length of the origin of base_link between two stamps, m.
  double length(Stamp from, Stamp to) const;

 private:
  Vector6d evaluate(Stamp stamp, int derivative) const;

  Stamp begin_;
  Stamp end_;
  double step_s_;
  std::vector<Vector6d> control_;
};

}  // namespace lidar_mapping::simulation
