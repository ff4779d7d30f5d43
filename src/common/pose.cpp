// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/pose.hpp"

#include <cmath>

#include <Eigen/SVD>

namespace lidar_mapping {

Pose Pose::from_matrix(const Eigen::Matrix4d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix.topLeftCorner<3, 3>(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d handedness = Eigen::Matrix3d::Identity();
  handedness(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d rotation = svd.matrixU() * handedness * svd.matrixV().transpose();
  return {Eigen::Quaterniond(rotation).normalized(), matrix.topRightCorner<3, 1>()};
}

Pose Pose::inverse() const {
  const Eigen::Quaterniond inverted = rotation.conjugate();
  return {inverted, -(inverted * translation)};
}

Eigen::Matrix4d Pose::matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = translation;
  return matrix;
}

Pose operator*(const Pose& T_a_b, const Pose& T_b_c) {
  return {(T_a_b.rotation * T_b_c.rotation).normalized(),
          T_a_b.translation + T_a_b.rotation * T_b_c.translation};
}

Eigen::Vector3d operator*(const Pose& T_a_b, const Eigen::Vector3d& p_b) {
  return T_a_b.rotation * p_b + T_a_b.translation;
}

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

Eigen::Quaterniond exp_so3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  // sin(x/2)/x by its series where the quotient loses digits.
  const double scale = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = scale * rotation_vector;
  return q.normalized();
}

Eigen::Vector3d log_so3(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * rotation.w();
  const Eigen::Vector3d v = sign * rotation.vec();
  const double sine = v.norm();
  if (sine < 1e-9) return 2.0 * v;
  return (2.0 * std::atan2(sine, w) / sine) * v;
}

Pose perturbed(const Pose& T, const Vector6d& d) {
  return T * Pose{exp_so3(d.tail<3>()), d.head<3>()};
}

Vector6d difference(const Pose& a, const Pose& b) {
  const Pose T_a_b = a.inverse() * b;
  Vector6d d;
  d << T_a_b.translation, log_so3(T_a_b.rotation);
  return d;
}

double rotation_angle(const Eigen::Quaterniond& rotation) {
  return 2.0 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

double yaw_of(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
  return std::atan2(matrix(1, 0), matrix(0, 0));
}

Pose interpolate(const Pose& a, const Pose& b, double fraction) {
  return {a.rotation.slerp(fraction, b.rotation).normalized(),
          a.translation + fraction * (b.translation - a.translation)};
}

bool is_finite(const Pose& pose) {
  return pose.rotation.coeffs().allFinite() && pose.translation.allFinite();
}

}  // namespace lidar_mapping
