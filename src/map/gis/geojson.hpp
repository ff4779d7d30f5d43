// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"

#include "json.hpp"

namespace lidar_mapping::map {

/// A number of JSON with three decimals; null for what is infinite.
json::Json rounded_number(double value);

/// Geometries of GeoJSON (RFC 7946) in WGS 84: longitude, latitude, height above the ellipsoid.
/// Without a datum positions are metres in the map frame.
class GeoJson {
 public:
  explicit GeoJson(const std::optional<GeodeticDatum>& datum) : datum_(datum) {}

  /// A line string, or a point if there is only one position.
  json::Json line(const std::vector<Eigen::Vector3d>& line_map) const;
  /// A polygon. The corners go round once, counter-clockwise from above.
  json::Json polygon(const std::vector<Eigen::Vector3d>& corners_map) const;

  /// Writes a layer, NAME.geojson or, without a datum, NAME_local_metres.geojson. Returns the file.
  /// Throws FileError.
  std::filesystem::path write(const std::string& name, const json::Json& features,
                              const std::filesystem::path& directory) const;

 private:
  json::Json positions(const std::vector<Eigen::Vector3d>& positions_map) const;

  const std::optional<GeodeticDatum> datum_;
};

/// A feature with its properties.
json::Json feature(const json::Json& geometry, const json::Json& properties);

}  // namespace lidar_mapping::map
