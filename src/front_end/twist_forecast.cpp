#include "lidar_mapping/front_end/twist_forecast.hpp"

#include <algorithm>

namespace lidar_mapping::front_end {
namespace {

constexpr double kLearningRate = 0.1;
/// Of a twist, squared: nothing.
constexpr double kTinyChange = 1e-12;

/// Mean squared difference per axis, linear and angular.
Eigen::Vector2d squared_difference(const Vector6d& a, const Vector6d& b,
                                   const Eigen::Matrix3d& observed) {
  const Vector6d d = a - b;
  const double axes = std::max(1.0, observed.trace());
  return {(observed * d.head<3>()).squaredNorm() / axes, d.tail<3>().squaredNorm() / 3.0};
}

}  // namespace

double TwistForecast::mean_share(int part) const {
  const double both = mean_error_[part] + sweep_error_[part];
  return both > 0.0 ? sweep_error_[part] / both : 0.0;
}

/// From the middle of a step to its end the twist changes as much as from there to the middle of
/// the next one if its acceleration is steady, and the other way round where it was noise.
void TwistForecast::learn_steadiness(const Vector6d& mean_twist, const Eigen::Matrix3d& observed) {
  Vector6d before = sweep_twist_ - mean_twist_;
  Vector6d after = mean_twist - sweep_twist_;
  before.head<3>() = observed * before.head<3>();
  after.head<3>() = observed * after.head<3>();
  continued_change_ += kLearningRate * (before.cwiseProduct(after) - continued_change_);
  squared_change_ += kLearningRate * (before.cwiseProduct(before) - squared_change_);
}

Vector6d TwistForecast::steadiness() const {
  return continued_change_.cwiseQuotient(squared_change_.cwiseMax(kTinyChange))
      .cwiseMax(0.0)
      .cwiseMin(1.0);
}

void TwistForecast::see(const Vector6d& mean_twist, const Vector6d& sweep_twist,
                        const Eigen::Matrix3d& observed) {
  if (seen_) {
    const auto learn = [&](const Vector6d& forecast, Eigen::Vector2d& error) {
      error += kLearningRate * (squared_difference(forecast, mean_twist, observed) - error);
    };
    learn(mean_twist_, mean_error_);
    learn(sweep_twist_, sweep_error_);
    learn_steadiness(mean_twist, observed);
  }
  const Vector6d to_mean = mean_twist - sweep_twist;
  next_.head<3>() = sweep_twist.head<3>() + mean_share(0) * (observed * to_mean.head<3>());
  next_.tail<3>() = sweep_twist.tail<3>() + mean_share(1) * to_mean.tail<3>();
  variance_ = mean_error_.cwiseMin(sweep_error_);
  mean_twist_ = mean_twist;
  sweep_twist_ = sweep_twist;
  seen_ = true;
}

}  // namespace lidar_mapping::front_end
