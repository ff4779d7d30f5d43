// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace lidar_mapping {

/// Six numbers, mostly translation (or velocity) before rotation (or angular velocity).
using Vector6d = Eigen::Matrix<double, 6, 1>;
/// 6x6, in the order of Vector6d.
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rigid motion. `T_a_b` is the pose of frame b in frame a and maps points from b to a.
/// The rotation is a unit quaternion that is normalised at every composition, so that long chains
/// stay rotations.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< R_a_b, of length 1
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< of b in a, m

  /// No motion, as Eigen names it.
  static Pose Identity() { return {}; }
  /// From a 4x4 (or the upper 3x4 of a) homogeneous matrix; its rotation is re-orthonormalised.
  static Pose from_matrix(const Eigen::Matrix4d& matrix);

  /// T_b_a.
  Pose inverse() const;
  /// The homogeneous 4x4 matrix.
  Eigen::Matrix4d matrix() const;
  /// R_a_b as a 3x3 matrix.
  Eigen::Matrix3d rotation_matrix() const { return rotation.toRotationMatrix(); }
};

/// T_a_c = T_a_b * T_b_c.
Pose operator*(const Pose& T_a_b, const Pose& T_b_c);
/// p_a = T_a_b * p_b.
Eigen::Vector3d operator*(const Pose& T_a_b, const Eigen::Vector3d& p_b);

/// The cross product as a matrix: skew(a) * b = a x b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Rotation vector (rad) to unit quaternion.
Eigen::Quaterniond exp_so3(const Eigen::Vector3d& rotation_vector);
/// Unit quaternion to rotation vector (rad) of length at most pi.
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

/// No number of the pose is infinite or NaN.
bool is_finite(const Pose& pose);

}  // namespace lidar_mapping
