// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace lidar_mapping {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rigid motion. `T_a_b` is the pose of frame b in frame a and maps points from b to a.
/// The rotation is a unit quaternion that is normalised at every composition, so that long chains
/// stay rotations.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static Pose Identity() { return {}; }
  /// From a 4x4 (or the upper 3x4 of a) homogeneous matrix; its rotation is re-orthonormalised.
  static Pose from_matrix(const Eigen::Matrix4d& matrix);

  Pose inverse() const;
  Eigen::Matrix4d matrix() const;
  Eigen::Matrix3d rotation_matrix() const { return rotation.toRotationMatrix(); }
};

/// T_a_c = T_a_b * T_b_c.
Pose operator*(const Pose& T_a_b, const Pose& T_b_c);
/// p_a = T_a_b * p_b.
Eigen::Vector3d operator*(const Pose& T_a_b, const Eigen::Vector3d& p_b);

/// The cross product as a matrix: skew(a) * b = a x b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Rotation vector (rad) to unit quaternion and back; the result of log has length at most pi.
Eigen::Quaterniond exp_so3(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d log_so3(const Eigen::Quaterniond& rotation);

/// The pose T * (d.head(3), exp(d.tail(3))): the package's one perturbation, in the axes of the
/// child frame, translation first. All covariances belong to it.
Pose perturbed(const Pose& T, const Vector6d& d);
/// The d for which perturbed(a, d) equals b.
Vector6d difference(const Pose& a, const Pose& b);

/// Angle of the shortest rotation, rad in [0, pi], the same for q and -q.
double rotation_angle(const Eigen::Quaterniond& rotation);
/// Angle about z, rad in (-pi, pi].
double yaw_of(const Eigen::Quaterniond& rotation);

/// Point on the way from a (fraction 0) to b (fraction 1): linear in translation, slerp in
/// rotation.
Pose interpolate(const Pose& a, const Pose& b, double fraction);

bool is_finite(const Pose& pose);

}  // namespace lidar_mapping
