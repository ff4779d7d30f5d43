// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// Autoware's layout: a PCD file per tile and pointcloud_map_metadata.yaml, which names the lower
/// corner of each. `tile_size` (m) is that of the source. Points are in the map frame. Only a tile
/// at a time is in memory. The folder appears whole or not at all; an older one with tiles is
/// replaced. Throws FileError, also where the folder holds something else, and InputError for
/// points too far from the origin (check_range()).
Files save_tiles(const TileSource& tiles, double tile_size, const std::filesystem::path& directory);

/// A LAS 1.2 file (point format 0). Coordinates are whole millimetres and never pass through float:
/// with a datum metres in the datum's UTM zone, whose EPSG code stands in the file, and heights
/// above the ellipsoid; without one the map frame. `max_intensity` is the largest in the map and
/// becomes 65535. Throws FileError.
void write_las(const std::filesystem::path& path, const TileSource& tiles,
               const std::optional<GeodeticDatum>& datum, float max_intensity);

/// What stands in the way of a vehicle: a cell with points between these heights above the local
/// ground is occupied; one with ground alone is free, and one without points through which a ray
/// of the LiDAR passed lower than `highest`; others are unknown.
struct GridOptions {
  double cell = 0.2;     ///< m; with less than the map's voxels walls have gaps
  double lowest = 0.3;   ///< m above the ground
  double highest = 2.0;  ///< m above the ground
  int min_points = 2;    ///< in a cell, to be occupied
  int threads = 0;       ///< 0: all cores
};

/// Key frames whose rays, from the LiDAR to each of their points, carve free space: clouds without
/// what moved, and the LiDAR's place in base_link, m.
struct GridRays {
  const KeyFramePoses& poses;
  CloudSource& clouds;
  Eigen::Vector3d p_base_sensor;
};

/// grid.pgm and grid.yaml for map_server, made block by block; without rays only what has points is
/// known. Throws InputError for a map without points, FileError.
Files save_grid(const CloudParts& map, const GridOptions& options,
                const std::filesystem::path& directory,
                const std::optional<GridRays>& rays = std::nullopt);

}  // namespace lidar_mapping::map
