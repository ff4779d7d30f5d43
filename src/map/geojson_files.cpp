// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/geodetic.hpp"

#include "json.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

using json::Json;
using Line = std::vector<Eigen::Vector3d>;

// Chosen: decimals of a degree are 0.1 mm, of a metre 1 mm.
constexpr double kDegreeSteps = 1e9;
constexpr double kMetreSteps = 1e3;

double rounded(double value, double steps) { return std::round(value * steps) / steps; }

/// A number of JSON, which has none for what is infinite.
Json number(double value) {
  return std::isfinite(value) ? Json(rounded(value, kMetreSteps)) : Json(nullptr);
}

double length_of(const Line& line) {
  double length = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

class Geometry {
 public:
  explicit Geometry(const std::optional<GeodeticDatum>& datum) : datum_(datum) {}

  /// A line string, or a point if there is only one position.
  Json of(const Line& line_map) const {
    Json positions = Json::array();
    const double steps = datum_ ? kDegreeSteps : kMetreSteps;
    for (const Eigen::Vector3d& p : datum_ ? geodetic_positions(*datum_, line_map) : line_map) {
      positions.push_back(
          {rounded(p.x(), steps), rounded(p.y(), steps), rounded(p.z(), kMetreSteps)});
    }
    if (positions.size() == 1) return {{"type", "Point"}, {"coordinates", positions[0]}};
    return {{"type", "LineString"}, {"coordinates", positions}};
  }

 private:
  const std::optional<GeodeticDatum>& datum_;
};

Json feature(const Json& geometry, const Json& properties) {
  return {{"type", "Feature"}, {"properties", properties}, {"geometry", geometry}};
}

Json way_features(const DriveMarks& marks, const Geometry& geometry) {
  std::map<std::uint32_t, std::vector<const WayPoint*>> drives;
  for (const WayPoint& point : marks.way) drives[point.segment].push_back(&point);
  Json features = Json::array();
  for (const auto& [drive, points] : drives) {
    Line line;
    for (const WayPoint* point : points) line.push_back(point->p_map);
    features.push_back(
        feature(geometry.of(line), {{"drive", drive},
                                    {"key_frames", points.size()},
                                    {"begin_s", number(to_seconds(points.front()->stamp))},
                                    {"end_s", number(to_seconds(points.back()->stamp))},
                                    {"length_m", number(length_of(line))}}));
  }
  return features;
}

Json loop_features(const DriveMarks& marks, const Geometry& geometry) {
  std::map<KeyFrameIndex, Eigen::Vector3d> positions;
  for (const WayPoint& point : marks.way) positions[point.index] = point.p_map;
  Json features = Json::array();
  for (const LoopMark& loop : marks.loops) {
    features.push_back(feature(geometry.of({positions.at(loop.from), positions.at(loop.to)}),
                               {{"from", loop.from},
                                {"to", loop.to},
                                {"verdict", to_string(loop.verdict)},
                                {"source", to_string(loop.source)},
                                {"reason", loop.reason}}));
  }
  return features;
}

Json doubt_features(const DriveMarks& marks, const Geometry& geometry) {
  Json features = Json::array();
  for (const DoubtMark& doubt : marks.doubts) {
    features.push_back(
        feature(geometry.of(doubt.way_map), {{"kind", doubt.kind},
                                             {"begin_s", number(to_seconds(doubt.begin))},
                                             {"end_s", number(to_seconds(doubt.end))},
                                             {"length_m", number(doubt.length)},
                                             {"expected_error_m", number(doubt.expected_error)},
                                             {"trusted", doubt.is_trusted}}));
  }
  return features;
}

}  // namespace

Files write_geojson(const DriveMarks& marks, const std::optional<GeodeticDatum>& datum,
                    const std::filesystem::path& directory) {
  const Geometry geometry(datum);
  const std::pair<const char*, Json> layers[] = {{"trajectory", way_features(marks, geometry)},
                                                 {"loops", loop_features(marks, geometry)},
                                                 {"doubt", doubt_features(marks, geometry)}};
  Files files;
  for (const auto& [name, features] : layers) {
    Json collection = {{"type", "FeatureCollection"}};
    if (!datum) collection["coordinates"] = "metres in the frame of the map, not WGS 84";
    collection["features"] = features;
    files.push_back(directory / (std::string(name) + (datum ? "" : "_local_metres") + ".geojson"));
    write_text_atomically(files.back(), json::dumped(collection) + "\n");
  }
  return files;
}

}  // namespace lidar_mapping::map
