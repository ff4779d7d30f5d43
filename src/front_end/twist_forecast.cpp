#include "lidar_mapping/front_end/twist_forecast.hpp"

#include <algorithm>

namespace lidar_mapping::front_end {
namespace {

constexpr double kLearningRate = 0.1;

/// Mean squared difference per axis, linear and angular.
Eigen::Vector2d squared_difference(const Vector6d& a, const Vector6d& b) {
  const Vector6d d = a - b;
  return {d.head<3>().squaredNorm() / 3.0, d.tail<3>().squaredNorm() / 3.0};
}

}  // namespace

void TwistForecast::see(const Vector6d& mean_twist, const Vector6d& sweep_twist) {
  if (seen_) {
    mean_error_ += kLearningRate * (squared_difference(mean_twist_, mean_twist) - mean_error_);
    sweep_error_ += kLearningRate * (squared_difference(sweep_twist_, mean_twist) - sweep_error_);
  }
  for (int part = 0; part < 2; ++part) {
    const double both = mean_error_[part] + sweep_error_[part];
    const double share = both > 0.0 ? mean_error_[part] / both : 1.0;
    next_.segment<3>(3 * part) =
        share * sweep_twist.segment<3>(3 * part) + (1.0 - share) * mean_twist.segment<3>(3 * part);
  }
  variance_ = mean_error_.cwiseMin(sweep_error_);
  mean_twist_ = mean_twist;
  sweep_twist_ = sweep_twist;
  seen_ = true;
}

}  // namespace lidar_mapping::front_end
