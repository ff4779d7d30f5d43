// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/utm.hpp"
#include "lidar_mapping/map/cloud_parts.hpp"

namespace lidar_mapping::map {

/// What a user of the map has to know besides its points; written as map.yaml.
struct MapDescription {
  std::string frame = "map";           ///< Name of the frame of the points (frame_id).
  std::optional<GeodeticDatum> datum;  ///< Origin of the East-North-Up frame; none without GNSS.
  double resolution = 0.0;             ///< Edge of the voxels, m.
  /// UTM zone of the points, which are relative to its origin; none: map frame.
  std::optional<UtmFrame> utm;
  std::string name = "map";  ///< Name of the files, without extension.
};

/// Paths of the files that were written.
using Files = std::vector<std::filesystem::path>;

/// Work that another thread does while files are written, because compression takes long and uses
/// one thread.
struct ConcurrentTask {
  /// Nothing to do if empty.
  std::function<void()> work;
  int threads = 1;  ///< With 1 the work is done after writing; 0: all cores.
};

/// Writes map.FORMAT for each of `formats` (empty: pcd and ply), which are of point_formats(),
/// and map.yaml (frame, datum, resolution, number of points, bounds) beside them; in UTM also
/// map.FORMAT.utm, which holds easting, northing and height of the origin. The origin is not
/// added to the points, because floats would lose precision. A file appears completely or not at
/// all. Where map.yaml changes, files of point_formats() that are not among `formats` are removed,
/// because it would not describe them. Throws InputError for another format or an empty map, and
/// FileError if the disk fails or if the folder holds a file of point_formats() without a map.yaml
/// beside it, so that it does not come from this package; in these cases `concurrent_task` has not
/// started.
Files write_point_files(const CloudParts& map, const MapDescription& description,
                        const std::filesystem::path& directory,
                        const std::vector<std::string>& formats,
                        const ConcurrentTask& concurrent_task = {});

/// Throws InputError if a point lies more than 100 km from the origin, where the floats of the
/// files would be off by centimetres.
void check_range(const PointCloud& cloud);

/// Writes a binary PCD file with the fields x y z intensity. Up to two million points are
/// compressed; larger maps are not, because compression needs all points in memory at once. Throws
/// FileError, and InputError like check_range().
void write_pcd(const std::filesystem::path& path, const CloudParts& map);
/// Writes a binary PLY file with the same fields. Throws like write_pcd().
void write_ply(const std::filesystem::path& path, const CloudParts& map);

/// Points of a tile in the map frame. Throws InputError like check_range().
PointCloud in_map_frame(const MapTile& tile);

}  // namespace lidar_mapping::map
