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

/// What a map's user has to know beside its points; written as map.yaml.
struct MapDescription {
  std::string frame = "map";
  std::optional<GeodeticDatum> datum;  ///< origin of East-North-Up; none without GNSS
  double resolution = 0.0;             ///< m, edge of the voxels
  std::optional<UtmFrame> utm;         ///< points are metres in it, from its origin on
  std::string name = "map";            ///< of the files, without extension
};

/// Names of files that were written.
using Files = std::vector<std::filesystem::path>;

/// What another thread does while files are written, as packing takes long and one thread.
struct Meanwhile {
  std::function<void()> work;
  int threads = 1;  ///< with one it is done afterwards; 0: all cores
};

/// Writes map.pcd (write_pcd()) and map.ply (binary), as `formats` (empty: both) says, and map.yaml
/// (frame, datum, resolution, number of points, bounds) beside them; in UTM also map.pcd.utm, which
/// has easting, northing and height of the origin. Files appear whole or not at all. Nothing large
/// is added to points, which floats would not hold. Throws InputError for another format or an
/// empty map, FileError for the disk, and where the folder holds a map.pcd or map.ply that does not
/// come from this package (no map.yaml beside it); what is to be done meanwhile is not begun then.
Files save_map(const CloudParts& map, const MapDescription& description,
               const std::filesystem::path& directory, const std::vector<std::string>& formats,
               const Meanwhile& meanwhile = {});

/// Throws InputError if a point lies more than 100 km from the origin: the files' floats would be
/// off by centimetres there.
void check_range(const PointCloud& cloud);

/// Fields x y z intensity, binary; PCD compressed up to two million points, as only what is in
/// memory as a whole can be compressed. Throws FileError.
void write_pcd(const std::filesystem::path& path, const CloudParts& map);
void write_ply(const std::filesystem::path& path, const CloudParts& map);

/// A tile's points in the map frame. Throws InputError as check_range().
PointCloud in_map_frame(const MapTile& tile);

}  // namespace lidar_mapping::map
