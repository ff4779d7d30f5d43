// SPDX-License-Identifier: BSD-3-Clause
#include "motion/deviation_filter.hpp"

#include <Eigen/LU>

namespace lidar_mapping::front_end {

Vector6d SweepDeviations::combined(const Eigen::Vector3d& weights) const {
  return weights[0] * poses.head<6>() + weights[1] * poses.segment<6>(6) +
         weights[2] * poses.tail<6>();
}

Covariance6 SweepDeviations::covariance_of(const Eigen::Vector3d& weights) const {
  Covariance6 sum = Covariance6::Zero();
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      sum += weights[a] * weights[b] * covariance.block<6, 6>(6 * a, 6 * b);
    }
  }
  return sum;
}

void DeviationFilter::begin(double seconds, const Vector12d& state, const Matrix12d& covariance) {
  seconds_ = -seconds;
  x_.head<12>() = state;
  P_.topLeftCorner<12, 12>() = covariance;
  keep(kBegin);
}

void DeviationFilter::predict(double seconds) {
  if (seconds_ < 0.0 && seconds >= 0.0) {
    advance(-seconds_);
    keep(kMiddle);
  }
  if (seconds > seconds_) advance(seconds - seconds_);
}

void DeviationFilter::measure(const NdtPart& part, double weight) {
  const Matrix6d H = weight * part.hessian;
  const Eigen::Matrix<double, kDimension, 6> P_d = P_.leftCols<6>();
  const Matrix6d information =
      (Matrix6d::Identity() + H * P_d.topRows<6>()).partialPivLu().solve(H);
  const Vector6d innovation = -weight * part.gradient - H * x_.head<6>();
  Eigen::Matrix<double, kDimension, 6> gain;
  gain.noalias() = P_d * information;
  // Rounding errors that are not symmetric would grow.
  for (int column = 0; column < kDimension; ++column) {
    for (int row = column; row < kDimension; ++row) {
      P_(row, column) -= gain.row(row).dot(P_d.row(column));
      P_(column, row) = P_(row, column);
    }
  }
  x_ += P_.leftCols<6>() * innovation;
}

SweepDeviations DeviationFilter::deviations() const {
  constexpr int kOrder[] = {kBegin, kMiddle, 0};
  SweepDeviations result;
  for (int a = 0; a < 3; ++a) {
    result.poses.segment<6>(6 * a) = x_.segment<6>(kOrder[a]);
    for (int b = 0; b < 3; ++b) {
      result.covariance.block<6, 6>(6 * a, 6 * b) = P_.block<6, 6>(kOrder[a], kOrder[b]);
    }
  }
  return result;
}

void DeviationFilter::keep(int where) {
  x_.segment<6>(where) = x_.head<6>();
  P_.middleRows<6>(where) = P_.topRows<6>();
  P_.middleCols<6>(where) = P_.leftCols<6>();
}

void DeviationFilter::advance(double t) {
  seconds_ += t;
  x_.head<6>() += t * x_.segment<6>(6) + 0.5 * t * t * mean_acceleration_;
  x_.segment<6>(6) += t * mean_acceleration_;
  P_.topRows<6>() += t * P_.middleRows<6>(6);
  P_.leftCols<6>() += t * P_.middleCols<6>(6);
  P_.block<6, 6>(0, 0).diagonal() += t * t * t / 3.0 * noise_;
  P_.block<6, 6>(0, 6).diagonal() += t * t / 2.0 * noise_;
  P_.block<6, 6>(6, 0).diagonal() += t * t / 2.0 * noise_;
  P_.block<6, 6>(6, 6).diagonal() += t * noise_;
}

}  // namespace lidar_mapping::front_end
