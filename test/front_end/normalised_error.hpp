// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Mean of squared errors in units of their covariance, per degree of freedom.
class NormalisedError {
 public:
  void add(const Pose& motion, const Pose& true_motion, const Covariance6& covariance) {
    const Vector6d error = difference(true_motion, motion);
    sum_ += error.dot(covariance.ldlt().solve(error)) / 6.0;
    ++count_;
  }
  double mean() const { return sum_ / count_; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

}  // namespace lidar_mapping::front_end
