// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/geodetic.hpp"

#include <cmath>

#include <GeographicLib/LocalCartesian.hpp>

namespace lidar_mapping {

bool is_place(const GeodeticDatum& datum) {
  constexpr double kHighest = 1e5;  // m; chosen: far above any mountain
  return std::abs(datum.latitude_deg) <= 90.0 && std::abs(datum.longitude_deg) <= 360.0 &&
         std::abs(datum.altitude_m) <= kHighest;
}

std::vector<Eigen::Vector3d> geodetic_positions(const GeodeticDatum& datum,
                                                const std::vector<Eigen::Vector3d>& points_enu) {
  const GeographicLib::LocalCartesian frame(datum.latitude_deg, datum.longitude_deg,
                                            datum.altitude_m);
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(points_enu.size());
  for (const Eigen::Vector3d& p_enu : points_enu) {
    Eigen::Vector3d& position = positions.emplace_back();
    frame.Reverse(p_enu.x(), p_enu.y(), p_enu.z(), position.y(), position.x(), position.z());
  }
  return positions;
}

}  // namespace lidar_mapping
