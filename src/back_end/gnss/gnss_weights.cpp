// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/gnss_weights.hpp"

#include <cmath>

#include "lidar_mapping/common/unknown_height.hpp"

namespace lidar_mapping::back_end {

Eigen::Matrix2d horizontal_covariance(const GnssPosition& position, const BackEndConfig& config) {
  const double min_stddev = config.gnss_min_stddev_m;
  return position.covariance.topLeftCorner<2, 2>() +
         min_stddev * min_stddev * Eigen::Matrix2d::Identity();
}

double horizontal_stddev(const GnssPosition& position, const BackEndConfig& config) {
  return std::sqrt(0.5 * horizontal_covariance(position, config).trace());
}

double altitude_stddev(const GnssPosition& position, const BackEndConfig& config) {
  return std::hypot(std::sqrt(position.covariance(2, 2)), config.gnss_min_stddev_altitude_m);
}

bool has_altitude(const GnssPosition& position) {
  return std::isfinite(position.p_enu_antenna.z()) && position.covariance(2, 2) > 0.0 &&
         has_height(position.covariance);
}

}  // namespace lidar_mapping::back_end
