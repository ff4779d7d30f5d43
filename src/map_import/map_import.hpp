// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::map_import {

/// What is to be imported, and how.
struct ImportOptions {
  std::filesystem::path map;           ///< a PCD file, or a folder of tiles
  std::string trajectory;              ///< poses T_map_base, TUM or KITTI; empty: find the ground
  double spacing = 5.0;                ///< least distance of two places, m
  double sensor_height = 1.8;          ///< of the LiDAR above the ground, m
  double base_height = 0.0;            ///< of base_link above the ground, m
  double resolution = 0.2;             ///< edge of the voxels by which the map is thinned, m
  std::optional<GeodeticDatum> datum;  ///< of the map's frame; none: as a file beside it names it
  int threads = 1;                     ///< at most so many; 0: all cores
};

/// Takes a line about what has been done.
using ImportLine = std::function<void(const std::string& line)>;
/// Takes the number of places that have a cloud, and that of all.
using ImportProgress = std::function<void(std::size_t done, std::size_t all)>;

/// Fills an empty session with a map that somebody else made (doc/localization.md): key frames at
/// places where a vehicle can be, each with what its LiDAR would see of the map. Throws FileError,
/// ConfigError, and InputError if no place is found or none sees the map.
void import_map(const ImportOptions& options, session::Session& session, const ImportLine& report,
                const ImportProgress& progress);

}  // namespace lidar_mapping::map_import
