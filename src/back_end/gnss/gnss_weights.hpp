// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::back_end {

/// Covariance and standard deviations of a position as the graph uses them.
Eigen::Matrix2d horizontal_covariance(const GnssPosition& position, const BackEndConfig& config);
double horizontal_stddev(const GnssPosition& position, const BackEndConfig& config);
double altitude_stddev(const GnssPosition& position, const BackEndConfig& config);
bool has_altitude(const GnssPosition& position);

}  // namespace lidar_mapping::back_end
