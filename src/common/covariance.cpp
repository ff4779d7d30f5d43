// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/covariance.hpp"

#include <Eigen/Cholesky>

namespace lidar_mapping {

Covariance6 diagonal_covariance(double sigma_m, double sigma_rad) {
  Vector6d variances;
  variances.head<3>().setConstant(sigma_m * sigma_m);
  variances.tail<3>().setConstant(sigma_rad * sigma_rad);
  return variances.asDiagonal();
}

Covariance6 in_parent_axes(const Covariance6& covariance, const Pose& T_parent_child) {
  const Eigen::Matrix3d R = T_parent_child.rotation_matrix();
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = R;
  turn.bottomRightCorner<3, 3>() = R;
  return turn * covariance * turn.transpose();
}

Matrix6d adjoint(const Pose& T) {
  const Eigen::Matrix3d R = T.rotation_matrix();
  Matrix6d result = Matrix6d::Zero();
  result.topLeftCorner<3, 3>() = R;
  result.topRightCorner<3, 3>() = skew(T.translation) * R;
  result.bottomRightCorner<3, 3>() = R;
  return result;
}

Covariance6 compose_covariance(const Covariance6& of_T_a_b, const Pose& T_b_c,
                               const Covariance6& of_T_b_c) {
  const Matrix6d carried = adjoint(T_b_c.inverse());
  return carried * of_T_a_b * carried.transpose() + of_T_b_c;
}

bool is_valid_covariance(const Covariance6& covariance) {
  if (!covariance.allFinite()) return false;
  const double scale = covariance.cwiseAbs().maxCoeff();
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) return false;
  return Eigen::LLT<Covariance6>(covariance).info() == Eigen::Success;
}

}  // namespace lidar_mapping
