// SPDX-License-Identifier: BSD-3-Clause
#include "matching/degeneracy.hpp"

#include <Eigen/Eigenvalues>

namespace lidar_mapping::front_end {

std::vector<Eigen::Vector3d> degenerate_directions(const Matrix6d& pose_hessian, double fraction) {
  const Eigen::Matrix3d H = pose_hessian.topLeftCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(H);
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < 3; ++i) {
    if (solver.eigenvalues()[i] > fraction * H.trace()) break;
    directions.emplace_back(solver.eigenvectors().col(i));
  }
  return directions;
}

Eigen::Matrix3d projection_orthogonal_to(const std::vector<Eigen::Vector3d>& directions) {
  Eigen::Matrix3d projection = Eigen::Matrix3d::Identity();
  for (const Eigen::Vector3d& d : directions) projection -= d * d.transpose();
  return projection;
}

}  // namespace lidar_mapping::front_end
