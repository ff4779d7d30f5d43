// SPDX-License-Identifier: BSD-3-Clause
#include "gis/geojson.hpp"

#include <cmath>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/geodetic.hpp"

namespace lidar_mapping::map {

namespace {

using json::Json;

// Chosen: decimals of a degree are 0.1 mm, of a metre 1 mm.
constexpr double kDegreeSteps = 1e9;
constexpr double kMetreSteps = 1e3;

double rounded(double value, double steps) { return std::round(value * steps) / steps; }

}  // namespace

Json rounded_number(double value) {
  return std::isfinite(value) ? Json(rounded(value, kMetreSteps)) : Json(nullptr);
}

Json GeoJson::positions(const std::vector<Eigen::Vector3d>& positions_map) const {
  Json result = Json::array();
  const double steps = datum_ ? kDegreeSteps : kMetreSteps;
  for (const Eigen::Vector3d& p :
       datum_ ? geodetic_positions(*datum_, positions_map) : positions_map) {
    result.push_back({rounded(p.x(), steps), rounded(p.y(), steps), rounded(p.z(), kMetreSteps)});
  }
  return result;
}

Json GeoJson::line(const std::vector<Eigen::Vector3d>& line_map) const {
  const Json coordinates = positions(line_map);
  if (coordinates.size() == 1) return {{"type", "Point"}, {"coordinates", coordinates[0]}};
  return {{"type", "LineString"}, {"coordinates", coordinates}};
}

Json GeoJson::polygon(const std::vector<Eigen::Vector3d>& corners_map) const {
  Json ring = positions(corners_map);
  ring.push_back(ring[0]);
  return {{"type", "Polygon"}, {"coordinates", Json::array({ring})}};
}

std::filesystem::path GeoJson::write(const std::string& name, const Json& features,
                                     const std::filesystem::path& directory) const {
  Json collection = {{"type", "FeatureCollection"}};
  if (!datum_) collection["frame"] = "metres in the frame of the map, not WGS 84";
  collection["features"] = features;
  const auto file = directory / (name + (datum_ ? "" : "_local_metres") + ".geojson");
  write_text_atomically(file, json::dumped(collection) + "\n");
  return file;
}

Json feature(const Json& geometry, const Json& properties) {
  return {{"type", "Feature"}, {"properties", properties}, {"geometry", geometry}};
}

}  // namespace lidar_mapping::map
