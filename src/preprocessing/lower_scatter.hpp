// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace lidar_mapping::preprocessing {

/// A sum of weighted outer products; solvers read only its lower triangle. Six scalar sums stay in
/// registers; a matrix would be read and written in memory for each point.
class LowerScatter {
 public:
  void add(const Eigen::Vector3d& d, double weight) {
    const double x = weight * d.x(), y = weight * d.y(), z = weight * d.z();
    xx_ += x * d.x();
    yx_ += y * d.x();
    zx_ += z * d.x();
    yy_ += y * d.y();
    zy_ += z * d.y();
    zz_ += z * d.z();
  }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d lower = Eigen::Matrix3d::Zero();
    lower.col(0) << xx_, yx_, zx_;
    lower.col(1).tail<2>() << yy_, zy_;
    lower(2, 2) = zz_;
    return lower;
  }

 private:
  double xx_ = 0.0, yx_ = 0.0, zx_ = 0.0, yy_ = 0.0, zy_ = 0.0, zz_ = 0.0;
};

}  // namespace lidar_mapping::preprocessing
