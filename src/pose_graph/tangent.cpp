// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/tangent.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// Writes the identity above a row of zeros, 7 x 6, row-major.
void write_identity(double* jacobian) {
  std::fill_n(jacobian, kPoseBlockSize * 6, 0.0);
  for (int i = 0; i < 6; ++i) jacobian[i * 6 + i] = 1.0;
}

}  // namespace

StateBlock to_block(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Pose to_pose(const double* block) {
  const Eigen::Quaterniond q(block[6], block[3], block[4], block[5]);
  return {q.normalized(), Eigen::Vector3d(block[0], block[1], block[2])};
}

StateBlock to_planar_block(const Pose& pose) {
  return {pose.translation.x(), pose.translation.y(), yaw_of(pose.rotation), 0.0, 0.0, 0.0, 0.0};
}

Pose to_planar_pose(const double* block) {
  return {exp_so3(Eigen::Vector3d(0.0, 0.0, std::remainder(block[2], 2.0 * kPi))),
          Eigen::Vector3d(block[0], block[1], 0.0)};
}

StateBlock retract(const double* block, const double* d) {
  const Eigen::Vector3d v(d[3], d[4], d[5]);
  // If |v| > 1 there is no unit quaternion with this vector part; half a turn is the nearest.
  const double squared = v.squaredNorm();
  const double w = squared < 1.0 ? std::sqrt(1.0 - squared) : 0.0;
  const Eigen::Quaterniond rotation(w, v.x(), v.y(), v.z());
  return to_block(to_pose(block) * Pose{rotation.normalized(), Eigen::Vector3d(d[0], d[1], d[2])});
}

bool TangentUpdate::Plus(const double* x, const double* d, double* x_plus_d) const {
  const StateBlock result = retract(x, d);
  std::copy(result.begin(), result.end(), x_plus_d);
  return true;
}

#if LIDAR_MAPPING_CERES_HAS_MANIFOLD

bool TangentUpdate::PlusJacobian(const double*, double* jacobian) const {
  write_identity(jacobian);
  return true;
}

bool TangentUpdate::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Pose T_x_y = to_pose(x).inverse() * to_pose(y);
  const double sign = T_x_y.rotation.w() < 0.0 ? -1.0 : 1.0;
  Eigen::Map<Vector6d> d(y_minus_x);
  d << T_x_y.translation, sign * T_x_y.rotation.vec();
  return true;
}

bool TangentUpdate::MinusJacobian(const double*, double* jacobian) const {
  std::fill_n(jacobian, 6 * kPoseBlockSize, 0.0);
  for (int i = 0; i < 6; ++i) jacobian[i * kPoseBlockSize + i] = 1.0;
  return true;
}

#else

bool TangentUpdate::ComputeJacobian(const double*, double* jacobian) const {
  write_identity(jacobian);
  return true;
}

#endif

}  // namespace lidar_mapping::pose_graph
