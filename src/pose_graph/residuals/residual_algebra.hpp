// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>

#include "lidar_mapping/pose_graph/tangent.hpp"

// Functions that several residuals use.

namespace lidar_mapping::pose_graph {

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

/// The same for a covariance: S times an error has unit covariance.
template <int size>
Eigen::Matrix<double, size, size> whitening(const Eigen::Matrix<double, size, size>& covariance) {
  return square_root<size>(covariance.inverse());
}

inline Eigen::Map<const Eigen::Vector3d> translation_of(const double* block) {
  return Eigen::Map<const Eigen::Vector3d>(block);
}

inline Eigen::Map<const Eigen::Quaterniond> rotation_of(const double* block) {
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

/// Two unit vectors orthogonal to `direction` and to each other, as rows.
inline Eigen::Matrix<double, 2, 3> orthogonal_basis(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 2, 3> rows;
  rows.row(0) = direction.unitOrthogonal();
  rows.row(1) = direction.cross(Eigen::Vector3d(rows.row(0)));
  return rows;
}

}  // namespace lidar_mapping::pose_graph
