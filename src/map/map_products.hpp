// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/drive_marks.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// Writes the map in Autoware's layout: a PCD file per tile and pointcloud_map_metadata.yaml, which
/// lists the lower corner of each tile. `tile_size` (m) is that of the source. Points are in the
/// map frame. Only one tile at a time is in memory. The folder appears completely or not at all; an
/// older folder with tiles is replaced. Throws FileError, also if the folder holds something else,
/// and InputError for points too far from the origin (check_range()).
Files write_tiles(const TileSource& tiles, double tile_size,
                  const std::filesystem::path& directory);

/// Writes a LAS 1.2 file (point format 0). Coordinates are whole millimetres and are never
/// converted to float. With a datum they are metres in the UTM zone of the datum, whose EPSG code
/// the file holds, and heights above the ellipsoid; without one they are in the map frame.
/// `max_intensity` is the largest in the map and is scaled to 65535. Throws FileError.
void write_las(const std::filesystem::path& path, const TileSource& tiles,
               const std::optional<GeodeticDatum>& datum, float max_intensity);

/// Writes trajectory.geojson (a line for each drive), loops.geojson and doubt.geojson in WGS 84
/// (RFC 7946: longitude, latitude, height above the ellipsoid). Without a datum their names end in
/// _local_metres.geojson, and positions are metres in the map frame. Throws FileError.
Files write_geojson(const DriveMarks& marks, const std::optional<GeodeticDatum>& datum,
                    const std::filesystem::path& directory);

/// Which cells of the 2D grid are obstacles for a vehicle. A cell with enough points between these
/// heights above the local ground is occupied; a cell with ground alone is free, and so is one
/// without points through which a ray of the LiDAR passed below `highest`; all others are unknown.
struct GridOptions {
  /// Edge of a cell, m; if it is smaller than the voxels of the map, walls have gaps.
  double cell = 0.2;
  double lowest = 0.3;   ///< Least height of an obstacle above the ground, m.
  double highest = 2.0;  ///< Largest height of an obstacle above the ground, m.
  int min_points = 2;    ///< Points of an occupied cell.
  int threads = 0;       ///< Upper limit of threads; 0: all cores.
};

/// Key frames whose rays, from the LiDAR to each of their points, show free space. The clouds are
/// without moving objects; `p_base_sensor` is the position of the LiDAR in base_link, m.
struct GridRays {
  const KeyFramePoses& poses;
  CloudSource& clouds;
  Eigen::Vector3d p_base_sensor;
};

/// Writes grid.pgm and grid.yaml for map_server, computed block by block. Without rays only cells
/// with points are known. Throws InputError for a map without points, and FileError.
Files write_grid(const CloudParts& map, const GridOptions& options,
                 const std::filesystem::path& directory,
                 const std::optional<GridRays>& rays = std::nullopt);

}  // namespace lidar_mapping::map
