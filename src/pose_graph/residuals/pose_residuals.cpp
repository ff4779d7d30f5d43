// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <ceres/sized_cost_function.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"

#include "residuals/residual_algebra.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Symbols, as in doc/back_end.md. The blocks are the poses of the nodes i (first) and j in the map.
//   q_i, R_i          rotation from the map to i: the conjugate of the one in the block
//   t_b, q_b, R_b     pose of j in i, by the blocks
//   t_z_              measured translation of j in i
//   q_z_, R_z_        conjugate of the measured rotation of j in i
//   S_                whitens the error: S^T S is the information
//   t_by_t, r_by_v    derivative of the translational error by a translation dt, of the rotational
//                     error by the vector part v, and so on; (dt, v) as in tangent.hpp

/// The vector part of q with positive w, and its derivative W for q * (1, v).
struct HalfAngle {
  Eigen::Vector3d vector;
  Eigen::Matrix3d derivative;

  explicit HalfAngle(const Eigen::Quaterniond& q) {
    const double sign = q.w() < 0.0 ? -1.0 : 1.0;
    vector = sign * q.vec();
    derivative = sign * q.w() * Eigen::Matrix3d::Identity() + skew(vector);
  }
};

class RelativePose : public ceres::SizedCostFunction<6, kPoseBlockSize, kPoseBlockSize> {
 public:
  RelativePose(const Pose& T_from_to, const Matrix6d& information)
      : t_z_(T_from_to.translation),
        q_z_(T_from_to.rotation.conjugate()),
        R_z_(q_z_.toRotationMatrix()),
        S_(square_root<6>(information)) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Quaterniond q_i = rotation_of(blocks[0]).conjugate();
    const Eigen::Quaterniond q_b = q_i * rotation_of(blocks[1]);
    const Eigen::Vector3d t_b = q_i * (translation_of(blocks[1]) - translation_of(blocks[0]));
    const HalfAngle rotation(q_z_ * q_b);
    Vector6d error;
    error << R_z_ * (t_b - t_z_), rotation.vector;
    vector_at<6>(residual) = S_ * error;
    if (jacobians == nullptr) return true;
    const Eigen::Matrix3d R_b = q_b.toRotationMatrix();
    if (jacobians[0] != nullptr) {
      write(jacobians[0], -R_z_, 2.0 * R_z_ * skew(t_b), -rotation.derivative * R_b.transpose());
    }
    if (jacobians[1] != nullptr) {
      write(jacobians[1], R_z_ * R_b, Eigen::Matrix3d::Zero(), rotation.derivative);
    }
    return true;
  }

 private:
  void write(double* target, const Eigen::Matrix3d& t_by_t, const Eigen::Matrix3d& t_by_v,
             const Eigen::Matrix3d& r_by_v) const {
    Jacobian<6> jacobian(target);
    const Eigen::Matrix3d S_tt = S_.topLeftCorner<3, 3>();
    const Eigen::Matrix3d S_tr = S_.topRightCorner<3, 3>();
    const Eigen::Matrix3d S_rr = S_.bottomRightCorner<3, 3>();
    jacobian.topLeftCorner<3, 3>().noalias() = S_tt * t_by_t;
    jacobian.block<3, 3>(0, 3).noalias() = S_tt * t_by_v + S_tr * r_by_v;
    jacobian.bottomLeftCorner<3, 3>().setZero();
    jacobian.block<3, 3>(3, 3).noalias() = S_rr * r_by_v;
    jacobian.col(6).setZero();
  }

  Eigen::Vector3d t_z_;
  Eigen::Quaterniond q_z_;  // conjugate of the measured rotation
  Eigen::Matrix3d R_z_;     // its transpose
  Matrix6d S_;
};

class Prior : public ceres::SizedCostFunction<6, kPoseBlockSize> {
 public:
  Prior(const Pose& T_map_base, const Matrix6d& information)
      : T_base_map_(T_map_base.inverse()), S_(square_root<6>(information)) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Quaterniond q = T_base_map_.rotation * rotation_of(blocks[0]);
    const HalfAngle rotation(q);
    Vector6d error;
    error << T_base_map_ * translation_of(blocks[0]), rotation.vector;
    vector_at<6>(residual) = S_ * error;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Matrix6d derivative = Matrix6d::Zero();
    derivative.topLeftCorner<3, 3>() = q.toRotationMatrix();
    derivative.bottomRightCorner<3, 3>() = rotation.derivative;
    write_jacobian<6>(jacobians[0], S_ * derivative);
    return true;
  }

 private:
  Pose T_base_map_;
  Matrix6d S_;
};

class PlanarRelativePose : public ceres::SizedCostFunction<3, kPlanarBlockSize, kPlanarBlockSize> {
 public:
  PlanarRelativePose(const Eigen::Vector3d& motion, const Eigen::Matrix3d& information)
      : motion_(motion),
        R_z_(Eigen::Rotation2Dd(-motion.z()).toRotationMatrix()),
        S_(square_root<3>(information)) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Matrix2d R_i = Eigen::Rotation2Dd(-blocks[0][2]).toRotationMatrix();
    const Eigen::Vector2d t_b =
        R_i * Eigen::Vector2d(blocks[1][0] - blocks[0][0], blocks[1][1] - blocks[0][1]);
    Eigen::Vector3d error;
    error << R_z_ * (t_b - motion_.head<2>()),
        std::remainder(blocks[1][2] - blocks[0][2] - motion_.z(), 2.0 * kPi);
    vector_at<3>(residual) = S_ * error;
    if (jacobians == nullptr) return true;
    const Eigen::Matrix2d R = R_z_ * R_i;
    Eigen::Matrix3d derivative = Eigen::Matrix3d::Identity();
    derivative.topLeftCorner<2, 2>() = R;
    using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    if (jacobians[1] != nullptr) Eigen::Map<RowMajor3>(jacobians[1], 3, 3) = S_ * derivative;
    if (jacobians[0] == nullptr) return true;
    derivative *= -1.0;
    derivative.topRightCorner<2, 1>() = R_z_ * Eigen::Vector2d(t_b.y(), -t_b.x());
    Eigen::Map<RowMajor3>(jacobians[0], 3, 3) = S_ * derivative;
    return true;
  }

 private:
  Eigen::Vector3d motion_;
  Eigen::Matrix2d R_z_;  // transpose of the measured rotation
  Eigen::Matrix3d S_;
};

}  // namespace

Matrix6d g2o_information(const Covariance6& covariance) {
  Vector6d half_angles;
  half_angles << 1.0, 1.0, 1.0, 2.0, 2.0, 2.0;
  const Matrix6d inverse = covariance.inverse();
  return half_angles.asDiagonal() * (0.5 * (inverse + inverse.transpose())) *
         half_angles.asDiagonal();
}

CostPtr relative_pose_residual(const Pose& T_from_to, const Matrix6d& information) {
  return std::make_unique<RelativePose>(T_from_to, information);
}

CostPtr prior_residual(const Pose& T_map_base, const Matrix6d& information) {
  return std::make_unique<Prior>(T_map_base, information);
}

CostPtr planar_relative_pose_residual(const Eigen::Vector3d& motion,
                                      const Eigen::Matrix3d& information) {
  return std::make_unique<PlanarRelativePose>(motion, information);
}

}  // namespace lidar_mapping::pose_graph
