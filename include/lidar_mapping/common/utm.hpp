// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include <Eigen/Core>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping {

/// The UTM zone of a datum (near the poles UPS) and the East-North-Up frame there. Easting,
/// northing and height above the WGS 84 ellipsoid in m; all points count in the datum's zone and on
/// its side of the equator, wherever they are.
class UtmFrame {
 public:
  /// The frame in the zone that the datum lies in.
  explicit UtmFrame(const GeodeticDatum& datum);

  /// Easting, northing, height of a point in East-North-Up about the datum; all m.
  Eigen::Vector3d from_enu(const Eigen::Vector3d& p_enu) const;
  /// The inverse of from_enu(). Throws InputError for points outside of the zone.
  Eigen::Vector3d to_enu(const Eigen::Vector3d& p_utm) const;
  /// Easting, northing, height of the datum itself, m.
  const Eigen::Vector3d& origin() const;
  /// The EPSG code of the plane system.
  std::uint16_t epsg() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace lidar_mapping
