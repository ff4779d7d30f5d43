// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping {

/// Whether latitude, longitude (degrees) and height (m) are those of a place on Earth.
bool is_place(const GeodeticDatum& datum);

/// WGS 84 longitude and latitude in degrees and height above the ellipsoid in m, in this order, of
/// points in East-North-Up about the datum (m).
std::vector<Eigen::Vector3d> geodetic_positions(const GeodeticDatum& datum,
                                                const std::vector<Eigen::Vector3d>& points_enu);

}  // namespace lidar_mapping
