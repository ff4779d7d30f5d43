// SPDX-License-Identifier: BSD-3-Clause
#include <map>

#include "lidar_mapping/common/path_length.hpp"

#include "gis/geojson.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

using json::Json;
using Line = std::vector<Eigen::Vector3d>;

double length_of(const Line& line) {
  return path_length(
      line.size(), [&](std::size_t i) -> const auto& { return line[i]; });
}

Json path_features(const DriveMarks& marks, const GeoJson& geojson) {
  std::map<std::uint32_t, std::vector<const PathPoint*>> drives;
  for (const PathPoint& point : marks.path) drives[point.segment].push_back(&point);
  Json features = Json::array();
  for (const auto& [drive, points] : drives) {
    Line line;
    for (const PathPoint* point : points) line.push_back(point->p_map);
    features.push_back(
        feature(geojson.line(line), {{"drive", drive},
                                     {"key_frames", points.size()},
                                     {"begin_s", rounded_number(to_seconds(points.front()->stamp))},
                                     {"end_s", rounded_number(to_seconds(points.back()->stamp))},
                                     {"length_m", rounded_number(length_of(line))}}));
  }
  return features;
}

Json loop_features(const DriveMarks& marks, const GeoJson& geojson) {
  std::map<KeyFrameIndex, Eigen::Vector3d> positions;
  for (const PathPoint& point : marks.path) positions[point.index] = point.p_map;
  Json features = Json::array();
  for (const LoopMark& loop : marks.loops) {
    features.push_back(feature(geojson.line({positions.at(loop.from), positions.at(loop.to)}),
                               {{"from", loop.from},
                                {"to", loop.to},
                                {"verdict", to_string(loop.verdict)},
                                {"source", to_string(loop.source)},
                                {"reason", loop.reason}}));
  }
  return features;
}

Json doubt_features(const DriveMarks& marks, const GeoJson& geojson) {
  Json features = Json::array();
  for (const DoubtMark& doubt : marks.doubts) {
    features.push_back(feature(geojson.line(doubt.path_map),
                               {{"kind", doubt.kind},
                                {"begin_s", rounded_number(to_seconds(doubt.begin))},
                                {"end_s", rounded_number(to_seconds(doubt.end))},
                                {"length_m", rounded_number(doubt.length)},
                                {"expected_error_m", rounded_number(doubt.expected_error)},
                                {"trusted", doubt.is_trusted}}));
  }
  return features;
}

}  // namespace

Files write_geojson(const DriveMarks& marks, const std::optional<GeodeticDatum>& datum,
                    const std::filesystem::path& directory) {
  const GeoJson geojson(datum);
  return {geojson.write("trajectory", path_features(marks, geojson), directory),
          geojson.write("loops", loop_features(marks, geojson), directory),
          geojson.write("doubt", doubt_features(marks, geojson), directory)};
}

}  // namespace lidar_mapping::map
