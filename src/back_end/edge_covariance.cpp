#include "lidar_mapping/back_end/edge_covariance.hpp"

#include <cmath>

namespace lidar_mapping::back_end {

namespace {

constexpr double kRadPerDeg = M_PI / 180.0;

}  // namespace

Covariance6 odometry_covariance(const Covariance6& of_registration, const Pose& T_previous_current,
                                const std::vector<Eigen::Vector3d>& degenerate_directions,
                                const BackEndConfig& config) {
  const double distance = T_previous_current.translation.norm();
  const double drift = std::hypot(config.odometry_min_stddev_m, config.odometry_drift * distance);
  const double turn =
      std::hypot(config.odometry_min_stddev_deg, config.odometry_drift_deg_per_m * distance) *
      kRadPerDeg;
  Covariance6 covariance = diagonal_covariance(drift, turn);
  if (is_valid_covariance(of_registration)) covariance += of_registration;
  const double blind = config.odometry_degenerate_drift * distance;
  for (const Eigen::Vector3d& direction : degenerate_directions) {
    covariance.topLeftCorner<3, 3>() += blind * blind * direction * direction.transpose();
  }
  return covariance;
}

Covariance6 loop_covariance(const Loop& loop, const BackEndConfig& config) {
  return loop.covariance +
         diagonal_covariance(config.loop_min_stddev_m, config.loop_min_stddev_deg * kRadPerDeg);
}

}  // namespace lidar_mapping::back_end
