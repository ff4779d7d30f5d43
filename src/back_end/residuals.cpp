#include "lidar_mapping/back_end/residuals.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <ceres/sized_cost_function.h>

#include "lidar_mapping/back_end/tangent.hpp"

namespace lidar_mapping::back_end {

namespace {

template <int rows>
using Jacobian = Eigen::Map<Eigen::Matrix<double, rows, kPoseBlockSize, Eigen::RowMajor>>;
template <int rows>
using TangentMatrix = Eigen::Matrix<double, rows, 6>;

/// Upper triangular S with S^T S = information.
template <int size>
Eigen::Matrix<double, size, size> square_root(
    const Eigen::Matrix<double, size, size>& information) {
  return Eigen::LLT<Eigen::Matrix<double, size, size>>(information).matrixU();
}

template <int size>
Eigen::Matrix<double, size, size> whitening(const Eigen::Matrix<double, size, size>& covariance) {
  return square_root<size>(covariance.inverse());
}

Eigen::Map<const Eigen::Vector3d> translation_of(const double* block) {
  return Eigen::Map<const Eigen::Vector3d>(block);
}

Eigen::Map<const Eigen::Quaterniond> rotation_of(const double* block) {
  return Eigen::Map<const Eigen::Quaterniond>(block + 3);
}

template <int size>
Eigen::Map<Eigen::Matrix<double, size, 1>> vector_at(double* values) {
  return Eigen::Map<Eigen::Matrix<double, size, 1>>(values);
}

template <int rows>
void write_jacobian(double* target, const TangentMatrix<rows>& derivative) {
  Jacobian<rows> jacobian(target);
  jacobian.template leftCols<6>() = derivative;
  jacobian.col(6).setZero();
}

/// The vector part of q with w made positive, and its derivative W for q * (1, v).
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
    const HalfAngle turn(q_z_ * q_b);
    Vector6d error;
    error << R_z_ * (t_b - t_z_), turn.vector;
    vector_at<6>(residual) = S_.triangularView<Eigen::Upper>() * error;
    if (jacobians == nullptr) return true;
    const Eigen::Matrix3d R_b = q_b.toRotationMatrix();
    if (jacobians[0] != nullptr) {
      write(jacobians[0], -R_z_, 2.0 * R_z_ * skew(t_b), -turn.derivative * R_b.transpose());
    }
    if (jacobians[1] != nullptr) {
      write(jacobians[1], R_z_ * R_b, Eigen::Matrix3d::Zero(), turn.derivative);
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
    const HalfAngle turn(q);
    Vector6d error;
    error << T_base_map_ * translation_of(blocks[0]), turn.vector;
    vector_at<6>(residual) = S_ * error;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Matrix6d derivative = Matrix6d::Zero();
    derivative.topLeftCorner<3, 3>() = q.toRotationMatrix();
    derivative.bottomRightCorner<3, 3>() = turn.derivative;
    write_jacobian<6>(jacobians[0], S_ * derivative);
    return true;
  }

 private:
  Pose T_base_map_;
  Matrix6d S_;
};

/// A linear function of the antenna's position: rows (t + R l - p).
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

/// Two unit vectors across `direction`, as rows.
Eigen::Matrix<double, 2, 3> across(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 2, 3> rows;
  rows.row(0) = direction.unitOrthogonal();
  rows.row(1) = direction.cross(Eigen::Vector3d(rows.row(0)));
  return rows;
}

class Tilt : public ceres::SizedCostFunction<2, kPoseBlockSize> {
 public:
  Tilt(const Eigen::Vector3d& up_base, double stddev)
      : weights_(across(up_base.normalized()) / stddev) {}

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
    residual[0] = weight_ * std::remainder(yaw - yaw_, 2.0 * M_PI);
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

/// The plane of the first floor, moved to the second node, against the floor seen there: two angles
/// and the height.
class CommonFloor : public ceres::SizedCostFunction<3, kPoseBlockSize, kPoseBlockSize> {
 public:
  CommonFloor(const Floor& first, const Floor& second, const Eigen::Matrix3d& covariance)
      : first_(first),
        across_(across(second.normal)),
        offset_(second.offset),
        S_(whitening<3>(covariance)) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Matrix3d R_i = rotation_of(blocks[0]).toRotationMatrix();
    const Eigen::Matrix3d R_b = R_i.transpose() * rotation_of(blocks[1]).toRotationMatrix();
    const Eigen::Vector3d t_b =
        R_i.transpose() * (translation_of(blocks[1]) - translation_of(blocks[0]));
    const Eigen::Vector3d normal = R_b.transpose() * first_.normal;
    Eigen::Vector3d error;
    error << across_ * normal, first_.offset + first_.normal.dot(t_b) - offset_;
    vector_at<3>(residual) = S_ * error;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      TangentMatrix<3> derivative = TangentMatrix<3>::Zero();
      derivative.block<2, 3>(0, 3) = across_ * R_b.transpose() * (-2.0 * skew(first_.normal));
      derivative.block<1, 3>(2, 0) = -first_.normal.transpose();
      derivative.block<1, 3>(2, 3) = 2.0 * first_.normal.transpose() * skew(t_b);
      write_jacobian<3>(jacobians[0], S_ * derivative);
    }
    if (jacobians[1] != nullptr) {
      TangentMatrix<3> derivative = TangentMatrix<3>::Zero();
      derivative.block<2, 3>(0, 3) = across_ * (2.0 * skew(normal));
      derivative.block<1, 3>(2, 0) = first_.normal.transpose() * R_b;
      write_jacobian<3>(jacobians[1], S_ * derivative);
    }
    return true;
  }

 private:
  Floor first_;
  Eigen::Matrix<double, 2, 3> across_;
  double offset_;
  Eigen::Matrix3d S_;
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
        std::remainder(blocks[1][2] - blocks[0][2] - motion_.z(), 2.0 * M_PI);
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

CostPtr antenna_horizontal_residual(const Eigen::Vector3d& p_map_antenna,
                                    const Eigen::Vector3d& p_base_antenna,
                                    const Eigen::Matrix2d& covariance) {
  Eigen::Matrix<double, 2, 3> weights = Eigen::Matrix<double, 2, 3>::Zero();
  weights.leftCols<2>() = whitening<2>(covariance);
  // The altitude may be missing; a weight of zero does not make that finite.
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

CostPtr common_floor_residual(const Floor& first, const Floor& second,
                              const Eigen::Matrix3d& covariance) {
  return std::make_unique<CommonFloor>(first, second, covariance);
}

CostPtr planar_relative_pose_residual(const Eigen::Vector3d& motion,
                                      const Eigen::Matrix3d& information) {
  return std::make_unique<PlanarRelativePose>(motion, information);
}

}  // namespace lidar_mapping::back_end
