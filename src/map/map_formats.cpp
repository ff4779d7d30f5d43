// SPDX-License-Identifier: BSD-3-Clause
#include "map_formats.hpp"

#include <optional>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/write_products.hpp"

#include "gis/geotiff_files.hpp"
#include "product_writer.hpp"
#include "web/web_page.hpp"

namespace lidar_mapping::map {

namespace {

// Rows of the table.

/// A format of points alone, which is a single file.
MapFormat points_format(const char* name, MapFormat::PointsWriter write_points) {
  MapFormat format;
  format.name = name;
  format.single_file = true;
  format.write_points = write_points;
  return format;
}

/// A format that is a single file, but needs more than the points.
MapFormat file_format(const char* name, MapFormat::ProductWriterMember write) {
  MapFormat format;
  format.name = name;
  format.single_file = true;
  format.write = write;
  return format;
}

/// A format of several files or folders, whose names do not depend on that of the map.
MapFormat folder_format(const char* name, const char* remark,
                        MapFormat::ProductWriterMember write) {
  MapFormat format;
  format.name = name;
  format.remark = remark;
  format.write = write;
  return format;
}

MapFormat with_obstacle(std::string (*obstacle)(), MapFormat format) {
  format.obstacle = obstacle;
  return format;
}

MapFormat with_check(void (*check)(const MapConfig& config), MapFormat format) {
  format.check = check;
  return format;
}

void check_grid_cell(const MapConfig& config) { grid_cell(config); }

}  // namespace

const std::vector<MapFormat>& map_formats() {
  using Writer = ProductWriter;
  static const std::vector<MapFormat> formats = {
      points_format("pcd", &write_pcd),
      points_format("ply", &write_ply),
      folder_format("png", "view from above", &Writer::write_picture),
      file_format("las", &Writer::write_las),
      folder_format("tiles", "Autoware", &Writer::write_tiles),
      with_check(&check_grid_cell, folder_format("grid", "map_server", &Writer::write_grid)),
      folder_format("ept", "Entwine Point Tiles", &Writer::write_ept),
      with_obstacle(&web_obstacle, folder_format("web", "page for a browser", &Writer::write_web)),
      with_obstacle(&geotiff_obstacle, folder_format("geotiff", "rasters", &Writer::write_geotiff)),
      folder_format("geojson", "trajectory, loops, doubt", &Writer::write_geojson),
      folder_format("changes", "between visits", &Writer::write_changes)};
  return formats;
}

const MapFormat* find_format(const std::string& name) {
  for (const MapFormat& format : map_formats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

std::vector<std::string> known_formats(const std::vector<std::string>& formats,
                                       const MapConfig& config) {
  std::vector<std::string> result;
  for (const std::string& format : formats) {
    result.push_back(lower_case(format));
    if (find_format(result.back()) == nullptr) {
      throw InputError("map format '" + format + "' is not known; use " +
                       joined(product_formats()));
    }
    const std::string obstacle = obstacle_to(result.back());
    if (!obstacle.empty()) throw InputError("map format '" + format + "': " + obstacle);
  }
  for (const std::string& format : result) {
    if (const auto check = find_format(format)->check) check(config);
  }
  return result;
}

void check_formats(const std::vector<std::string>& formats, const MapConfig& config) {
  known_formats(formats, config);
}

std::string obstacle_to(const std::string& format) {
  const MapFormat* known = find_format(format);
  return known == nullptr || known->obstacle == nullptr ? std::string() : known->obstacle();
}

const std::vector<std::string>& product_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const MapFormat& format : map_formats()) all.emplace_back(format.name);
    return all;
  }();
  return names;
}

std::string product_format_help() {
  std::vector<std::string> texts;
  for (const MapFormat& format : map_formats()) {
    texts.emplace_back(format.name);
    if (*format.remark != '\0') texts.back() += " (" + std::string(format.remark) + ")";
  }
  return joined(texts);
}

std::vector<std::string> single_file_formats() {
  std::vector<std::string> names;
  for (const MapFormat& format : map_formats()) {
    if (format.single_file) names.emplace_back(format.name);
  }
  return names;
}

std::vector<std::string> point_formats() {
  std::vector<std::string> names;
  for (const MapFormat& format : map_formats()) {
    if (format.write_points != nullptr) names.emplace_back(format.name);
  }
  return names;
}

}  // namespace lidar_mapping::map
