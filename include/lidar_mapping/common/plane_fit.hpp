// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace lidar_mapping {

/// Sums over points, from which their mean and spread follow. In double precision, which is exact
/// enough for a cell of some metres a few hundred metres from the origin; add points that are wider
/// spread or farther away relative to a point nearby.
struct PointMoments {
  double count = 0.0;                                 ///< number of points
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();      ///< of the positions, m
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();  ///< sum of p p^T, m^2

  /// Adds one point, in m.
  void add(const Eigen::Vector3d& point) {
    count += 1.0;
    sum += point;
    squares += point * point.transpose();
  }
  /// Of the points so far, m; there has to be one.
  Eigen::Vector3d mean() const { return sum / count; }
  /// About the mean, divided by the number of points, m^2; there has to be one.
  Eigen::Matrix3d covariance() const { return squares / count - mean() * mean().transpose(); }
};

/// The plane through the mean of points that lies closest to them in the sense of least squares.
struct PlaneFit {
  Eigen::Vector3d normal;     ///< of length 1; which of the two directions is open
  Eigen::Vector3d mean;       ///< m
  Eigen::Vector3d variances;  ///< m^2, along the normal first, then in the plane, rising

  /// From the eigenvectors of the covariance; three points or more make a plane.
  explicit PlaneFit(const PointMoments& moments);
};

}  // namespace lidar_mapping
