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

void check_grid_cell(const MapConfig& config) { grid_cell(config); }

/// The names of the formats that are wanted, in the order of the table.
template <typename IsWanted>
std::vector<std::string> names_of(const IsWanted& is_wanted) {
  std::vector<std::string> names;
  for (const MapFormat& format : map_formats()) {
    if (is_wanted(format)) names.emplace_back(format.name);
  }
  return names;
}

}  // namespace

const std::vector<MapFormat>& map_formats() {
  using Writer = ProductWriter;
  // name, remark, single file, writer of points or of all else, obstacle, check
  static const std::vector<MapFormat> formats = {
      {"pcd", "", true, &write_pcd},
      {"ply", "", true, &write_ply},
      {"png", "view from above", false, nullptr, &Writer::write_picture},
      {"las", "", true, nullptr, &Writer::write_las},
      {"tiles", "Autoware", false, nullptr, &Writer::write_tiles},
      {"grid", "map_server", false, nullptr, &Writer::write_grid, nullptr, &check_grid_cell},
      {"ept", "Entwine Point Tiles", false, nullptr, &Writer::write_ept},
      {"web", "page for a browser", false, nullptr, &Writer::write_web, &web_obstacle},
      {"geotiff", "rasters", false, nullptr, &Writer::write_geotiff, &geotiff_obstacle},
      {"geojson", "trajectory, loops, doubt", false, nullptr, &Writer::write_geojson},
      {"changes", "between visits", false, nullptr, &Writer::write_changes}};
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
  static const auto names = names_of([](const MapFormat&) { return true; });
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
  return names_of([](const MapFormat& format) { return format.single_file; });
}

std::vector<std::string> point_formats() {
  return names_of([](const MapFormat& format) { return format.write_points != nullptr; });
}

}  // namespace lidar_mapping::map
