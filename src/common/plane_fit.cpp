// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/plane_fit.hpp"

#include <Eigen/Eigenvalues>

namespace lidar_mapping {

PlaneFit::PlaneFit(const PointMoments& moments) : mean(moments.mean()) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments.covariance());
  normal = solver.eigenvectors().col(0);
  variances = solver.eigenvalues().cwiseMax(0.0);
}

}  // namespace lidar_mapping
