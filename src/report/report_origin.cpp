// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/session/imported_map.hpp"

#include "report_figures.hpp"
#include "run_record.hpp"

namespace lidar_mapping::report {

namespace {

namespace fs = std::filesystem;

json::Json date_of(const ReportInput& input) {
  if (input.poses.poses.empty() || input.poses.poses.front().stamp < kFirstDate) return nullptr;
  return utc(static_cast<std::time_t>(to_seconds(input.poses.poses.front().stamp)));
}

/// Describes unit and axes of the coordinates of map and trajectories.
std::string coordinates_of(const ReportInput& input) {
  const auto datum = input.session.datum();
  if (!datum && session::is_imported_map(input.session)) {
    return "those of the imported map, m, less its origin in config.yaml";
  }
  if (!datum) return "local, m: the first key frame is the origin, x forward, y left, z up";
  const std::string text = formatted("%.7f°, %.7f°, %.3f m above the ellipsoid (WGS 84)",
                                     datum->latitude_deg, datum->longitude_deg, datum->altitude_m);
  if (is_in_enu(input.session)) return "local East-North-Up, m, with its origin at " + text;
  return "local, m, not georeferenced (GNSS is not used or cannot place it); its datum is " + text;
}

/// The numbers after "name: [" in the description of a map.
json::Json list_in(const std::string& text, const std::string& name) {
  const std::size_t begin = text.find(name + ": [");
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  if (begin == std::string::npos ||
      std::sscanf(text.c_str() + begin + name.size() + 3, "%lf, %lf, %lf", &x, &y, &z) != 3) {
    return nullptr;
  }
  return {x, y, z};
}

std::uintmax_t bytes_of(const fs::path& path) {
  if (fs::is_regular_file(path)) return fs::file_size(path);
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

/// Purpose of each file, in the order of the page.
const std::pair<const char*, const char*> kProducts[] = {
    {"map/map.pcd", "point cloud of the map (PCD)"},
    {"map/map.ply", "point cloud of the map (PLY)"},
    {"map/map.las", "point cloud of the map (LAS)"},
    {"map/pointcloud_map", "point cloud in tiles (Autoware)"},
    {"map/ept", "point cloud with levels of detail (Entwine Point Tiles)"},
    {"map/ept/index.html", "page that shows the map in a browser"},
    {"map/height.tif", "heights (GeoTIFF)"},
    {"map/intensity.tif", "intensities (GeoTIFF)"},
    {"map/density.tif", "points per square metre (GeoTIFF)"},
    {"map/trajectory.geojson", "trajectory for a GIS (GeoJSON)"},
    {"map/loops.geojson", "loops for a GIS (GeoJSON)"},
    {"map/doubt.geojson", "doubtful stretches for a GIS (GeoJSON)"},
    {"map/map.yaml", "frame, origin, resolution and extent of the map"},
    {"map/top_view.png", "the map from above"},
    {"map/grid.pgm", "occupancy grid (map_server)"},
    {"map/moving_objects.pcd", "points of moving objects that were left out"},
    {"trajectory/optimized.tum", "optimised poses of the key frames"},
    {"trajectory/laser_odom.tum", "odometry of the key frames"},
    {"trajectory/laser_odom_scans.tum", "odometry of every scan"},
    {"trajectory/gnss.tum", "GNSS track"},
    {"graph.g2o", "pose graph"},
    {"loops.csv", "loops"},
    {"candidates.csv", "candidates for loops, taken or not"},
    {"key_frames", "clouds of the key frames (PCD)"},
    {"config.yaml", "all parameters in force"},
    {"session.db", "everything that is known of the drive (SQLite)"}};

}  // namespace

json::Json origin_figures(const ReportInput& input) {
  json::Json origin = {{"date", date_of(input)}, {"coordinates", coordinates_of(input)},
                       {"recording", nullptr},   {"sensors", json::Json::array()},
                       {"software", nullptr},    {"command", nullptr},
                       {"mapped", nullptr},      {"configuration", input.session.configurations()}};
  const auto record = read_run_record(input.session.directory());
  if (!record) return origin;
  origin["recording"] = json::Json::array();
  for (const RecordedFile& file : record->files) {
    origin["recording"].push_back({{"name", file.name}, {"bytes", file.bytes}});
  }
  origin["sensors"] = record->sensors;
  origin["software"] = record->software;
  origin["command"] = record->command;
  origin["mapped"] = record->date;
  return origin;
}

json::Json product_figures(const ReportInput& input) {
  const fs::path& directory = input.session.directory();
  json::Json files = json::Json::array();
  for (const auto& [name, meaning] : kProducts) {
    if (!fs::exists(directory / name)) continue;
    files.push_back({{"name", name}, {"meaning", meaning}, {"bytes", bytes_of(directory / name)}});
  }
  std::ifstream stream(directory / "map" / "map.yaml");
  std::ostringstream text;
  text << stream.rdbuf();
  return {{"files", files},
          {"map_min_m", list_in(text.str(), "min")},
          {"map_max_m", list_in(text.str(), "max")}};
}

}  // namespace lidar_mapping::report
