// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/sized_cost_function.h>

#include "lidar_mapping/pose_graph/residuals.hpp"

#include "residuals/residual_algebra.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Symbols, as in doc/back_end.md. The blocks are the poses of the nodes i (first) and j in the map.
//   R_i         rotation of i
//   t_b, R_b    pose of j in i, by the blocks (t_ij, R_ij there)
//   normal      that of the first floor, in j
//   S_          whitens the error: S^T S is the inverse covariance

/// The plane of the first floor, transformed to the second node, compared with the floor measured
/// there: two angles and the height.
class CommonFloor : public ceres::SizedCostFunction<3, kPoseBlockSize, kPoseBlockSize> {
 public:
  CommonFloor(const Floor& first, const Floor& second, const Eigen::Matrix3d& covariance)
      : first_(first),
        orthogonal_basis_(orthogonal_basis(second.normal)),
        offset_(second.offset),
        S_(whitening<3>(covariance)) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Matrix3d R_i = rotation_of(blocks[0]).toRotationMatrix();
    const Eigen::Matrix3d R_b = R_i.transpose() * rotation_of(blocks[1]).toRotationMatrix();
    const Eigen::Vector3d t_b =
        R_i.transpose() * (translation_of(blocks[1]) - translation_of(blocks[0]));
    const Eigen::Vector3d normal = R_b.transpose() * first_.normal;
    Eigen::Vector3d error;
    error << orthogonal_basis_ * normal, first_.offset + first_.normal.dot(t_b) - offset_;
    vector_at<3>(residual) = S_ * error;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      TangentMatrix<3> derivative = TangentMatrix<3>::Zero();
      derivative.block<2, 3>(0, 3) =
          orthogonal_basis_ * R_b.transpose() * (-2.0 * skew(first_.normal));
      derivative.block<1, 3>(2, 0) = -first_.normal.transpose();
      derivative.block<1, 3>(2, 3) = 2.0 * first_.normal.transpose() * skew(t_b);
      write_jacobian<3>(jacobians[0], S_ * derivative);
    }
    if (jacobians[1] != nullptr) {
      TangentMatrix<3> derivative = TangentMatrix<3>::Zero();
      derivative.block<2, 3>(0, 3) = orthogonal_basis_ * (2.0 * skew(normal));
      derivative.block<1, 3>(2, 0) = first_.normal.transpose() * R_b;
      write_jacobian<3>(jacobians[1], S_ * derivative);
    }
    return true;
  }

 private:
  Floor first_;
  Eigen::Matrix<double, 2, 3> orthogonal_basis_;
  double offset_;
  Eigen::Matrix3d S_;
};

}  // namespace

CostPtr common_floor_residual(const Floor& first, const Floor& second,
                              const Eigen::Matrix3d& covariance) {
  return std::make_unique<CommonFloor>(first, second, covariance);
}

}  // namespace lidar_mapping::pose_graph
