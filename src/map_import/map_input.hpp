// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::map_import {

/// A point of a map, in double precision: coordinates may be those of UTM.
struct MapPoint {
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();  ///< m
  float intensity = 0.0F;                           ///< as the file has it; 0 if it has none
};

/// Takes the points of a map part by part.
using MapPointSink = std::function<void(const std::vector<MapPoint>&)>;

/// The PCD files of a map: the file itself, the tiles that pointcloud_map_metadata.yaml of a folder
/// names (Autoware's layout, which build_map writes, too), or all PCD files of a folder without
/// such a list. Throws FileError and ConfigError.
std::vector<std::filesystem::path> map_files(const std::filesystem::path& map);

/// Reads the points of a PCD file of any encoding; coordinates are floats of 4 or 8 bytes. Points
/// whose coordinates are no numbers, or beyond kMaxCoordinate, are left out. A binary file is read
/// in parts, the others take their size in memory. Throws FileError, and InputError where floats of
/// 4 bytes cannot hold the coordinates.
void read_points(const std::filesystem::path& file, const MapPointSink& sink);

/// The datum that a file beside the map names: NAME.yaml of a map that build_map wrote in
/// East-North-Up, or Autoware's map_projector_info.yaml with a LocalCartesian projector. None
/// without such a file, or if it cannot be understood.
std::optional<GeodeticDatum> datum_beside(const std::filesystem::path& map);

}  // namespace lidar_mapping::map_import
