// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <ceres/sized_cost_function.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"

#include "residuals/residual_algebra.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Symbols, as in doc/back_end.md. The block is the pose (t, R) of the node in the map.
//   p_map_     p: measured position of the antenna
//   p_base_    l: lever arm of the antenna
//   up         the map's z axis in the node
//   weights_   rows that are measured, divided by their standard deviations: they whiten the error
//   by_axis    derivative of the yaw by the direction of the node's x axis in the map

/// A linear function of the antenna's position: weights (t + R l - p).
template <int rows>
class Antenna : public ceres::SizedCostFunction<rows, kPoseBlockSize> {
 public:
  Antenna(const Eigen::Vector3d& p_map, const Eigen::Vector3d& p_base,
          const Eigen::Matrix<double, rows, 3>& weights)
      : p_map_(p_map), p_base_(p_base), weights_(weights) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Matrix3d R = rotation_of(blocks[0]).toRotationMatrix();
    vector_at<rows>(residual) = weights_ * (translation_of(blocks[0]) + R * p_base_ - p_map_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    TangentMatrix<rows> derivative;
    derivative.template leftCols<3>() = weights_ * R;
    derivative.template rightCols<3>() = weights_ * (-2.0 * R * skew(p_base_));
    write_jacobian<rows>(jacobians[0], derivative);
    return true;
  }

 private:
  Eigen::Vector3d p_map_;
  Eigen::Vector3d p_base_;
  Eigen::Matrix<double, rows, 3> weights_;
};

class Tilt : public ceres::SizedCostFunction<2, kPoseBlockSize> {
 public:
  Tilt(const Eigen::Vector3d& up_base, double stddev)
      : weights_(orthogonal_basis(up_base.normalized()) / stddev) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Vector3d up = rotation_of(blocks[0]).conjugate() * Eigen::Vector3d::UnitZ();
    vector_at<2>(residual) = weights_ * up;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    TangentMatrix<2> derivative = TangentMatrix<2>::Zero();
    derivative.rightCols<3>() = weights_ * (2.0 * skew(up));
    write_jacobian<2>(jacobians[0], derivative);
    return true;
  }

 private:
  Eigen::Matrix<double, 2, 3> weights_;
};

class Heading : public ceres::SizedCostFunction<1, kPoseBlockSize> {
 public:
  Heading(double yaw, double stddev) : yaw_(yaw), weight_(1.0 / stddev) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Matrix3d R = rotation_of(blocks[0]).toRotationMatrix();
    const double yaw = std::atan2(R(1, 0), R(0, 0));
    residual[0] = weight_ * std::remainder(yaw - yaw_, 2.0 * kPi);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const Eigen::RowVector3d by_axis =
        Eigen::RowVector3d(-R(1, 0), R(0, 0), 0.0) / (R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
    TangentMatrix<1> derivative = TangentMatrix<1>::Zero();
    derivative.rightCols<3>() = weight_ * by_axis * (-2.0 * R * skew(Eigen::Vector3d::UnitX()));
    write_jacobian<1>(jacobians[0], derivative);
    return true;
  }

 private:
  double yaw_;
  double weight_;
};

}  // namespace

CostPtr antenna_horizontal_residual(const Eigen::Vector3d& p_map_antenna,
                                    const Eigen::Vector3d& p_base_antenna,
                                    const Eigen::Matrix2d& covariance) {
  Eigen::Matrix<double, 2, 3> weights = Eigen::Matrix<double, 2, 3>::Zero();
  weights.leftCols<2>() = whitening<2>(covariance);
  // The altitude may be NaN, and a weight of zero would not remove that.
  const Eigen::Vector3d p_map(p_map_antenna.x(), p_map_antenna.y(), 0.0);
  return std::make_unique<Antenna<2>>(p_map, p_base_antenna, weights);
}

CostPtr antenna_altitude_residual(double z_map_antenna, const Eigen::Vector3d& p_base_antenna,
                                  double stddev) {
  return std::make_unique<Antenna<1>>(Eigen::Vector3d(0.0, 0.0, z_map_antenna), p_base_antenna,
                                      Eigen::RowVector3d(0.0, 0.0, 1.0 / stddev));
}

CostPtr tilt_residual(const Eigen::Vector3d& up_base, double stddev) {
  return std::make_unique<Tilt>(up_base, stddev);
}

CostPtr heading_residual(double yaw, double stddev) {
  return std::make_unique<Heading>(yaw, stddev);
}

}  // namespace lidar_mapping::pose_graph
