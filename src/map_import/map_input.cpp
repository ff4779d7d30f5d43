// SPDX-License-Identifier: BSD-3-Clause
#include "map_input.hpp"

#include <string>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/folder_entries.hpp"
#include "lidar_mapping/common/geodetic.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/config/value.hpp"

namespace lidar_mapping::map_import {

namespace {

namespace fs = std::filesystem;

constexpr const char* kTileList = "pointcloud_map_metadata.yaml";
constexpr const char* kProjector = "map_projector_info.yaml";
/// Where Autoware keeps the tiles if their list lies beside them.
constexpr const char* kTileFolders[] = {"", "pointcloud_map.pcd", "pointcloud_map"};

bool is_pcd(const fs::path& path) { return lower_case(path.extension().string()) == ".pcd"; }

fs::path tile_file(const fs::path& folder, const std::string& name) {
  for (const char* inner : kTileFolders) {
    if (fs::is_regular_file(folder / inner / name)) return folder / inner / name;
  }
  throw FileError("the tile " + name + ", which " + (folder / kTileList).string() +
                  " names, is missing; copy the whole map");
}

std::vector<fs::path> listed_tiles(const fs::path& folder) {
  const config::Source list = config::read_yaml_file((folder / kTileList).string());
  std::vector<fs::path> files;
  for (const auto& [name, corner] : std::get<config::Value::Map>(list.values.data)) {
    if (is_pcd(name)) files.push_back(tile_file(folder, name));
  }
  if (!files.empty()) return files;
  throw FileError((folder / kTileList).string() + " names no PCD file; is it that of a map?");
}

std::vector<fs::path> pcd_files_in(const fs::path& folder) {
  std::vector<fs::path> files = sorted_paths_in(folder, [](const fs::directory_entry& entry) {
    return entry.is_regular_file() && is_pcd(entry.path());
  });
  if (!files.empty()) return files;
  throw FileError("there is neither " + std::string(kTileList) + " nor a PCD file in " +
                  folder.string() + "; name a PCD file, or the folder of a map in tiles");
}

/// The value of a map in a YAML file; null if there is none of that name.
const config::Value* find(const config::Value& values, const std::string& name) {
  const auto* const map = std::get_if<config::Value::Map>(&values.data);
  if (map == nullptr) return nullptr;
  const auto found = map->find(name);
  return found == map->end() ? nullptr : &found->second;
}

std::optional<double> number_in(const config::Value& values, const std::string& name) {
  const config::Value* const value = find(values, name);
  if (value == nullptr) return std::nullopt;
  if (const auto* const whole = std::get_if<int>(&value->data)) return *whole;
  if (const auto* const real = std::get_if<double>(&value->data)) return *real;
  return std::nullopt;
}

bool has_word(const config::Value& values, const std::string& name, const std::string& word) {
  const config::Value* const value = find(values, name);
  if (value == nullptr) return false;
  const auto* const text = std::get_if<std::string>(&value->data);
  return text != nullptr && lower_case(*text) == lower_case(word);
}

std::optional<GeodeticDatum> datum_of(const config::Value* place) {
  if (place == nullptr) return std::nullopt;
  const auto latitude = number_in(*place, "latitude");
  const auto longitude = number_in(*place, "longitude");
  const auto altitude = number_in(*place, "altitude");
  if (!latitude || !longitude || !altitude) return std::nullopt;
  const GeodeticDatum datum{*latitude, *longitude, *altitude};
  return is_place(datum) ? std::optional(datum) : std::nullopt;
}

std::optional<GeodeticDatum> datum_in(const fs::path& file) {
  if (!fs::is_regular_file(file)) return std::nullopt;
  const config::Value values = config::read_yaml_file(file.string()).values;
  if (file.filename() != kProjector) {
    return has_word(values, "frame", "utm") ? std::nullopt : datum_of(find(values, "datum"));
  }
  // Heights above the geoid would need a model of it.
  const bool is_enu =
      has_word(values, "projector_type", "LocalCartesian") &&
      (find(values, "vertical_datum") == nullptr || has_word(values, "vertical_datum", "WGS84"));
  return is_enu ? datum_of(find(values, "map_origin")) : std::nullopt;
}

}  // namespace

std::vector<fs::path> map_files(const fs::path& map) {
  if (!fs::exists(map)) throw FileError("there is no map " + map.string());
  if (fs::is_directory(map)) {
    return fs::exists(map / kTileList) ? listed_tiles(map) : pcd_files_in(map);
  }
  const std::string extension = lower_case(map.extension().string());
  if (extension != ".las" && extension != ".laz") return {map};
  throw FileError(map.string() + " is a LAS file, which is not read; make a PCD file of it first");
}

std::optional<GeodeticDatum> datum_beside(const fs::path& map) {
  const bool is_folder = fs::is_directory(map);
  std::vector<fs::path> files;
  if (is_folder) {
    files = {map / kProjector, map / ".." / kProjector};
  } else {
    files = {fs::path(map).replace_extension(".yaml"), map.parent_path() / kProjector};
  }
  for (const fs::path& file : files) {
    try {
      if (const auto datum = datum_in(file)) return datum;
    } catch (const ConfigError&) {
      // A file of somebody else that has the same name.
    }
  }
  return std::nullopt;
}

}  // namespace lidar_mapping::map_import
