// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// Why this build cannot write GeoTIFF, with the remedy; empty if it can.
std::string geotiff_obstacle();

/// Writes height.tif (the highest point of each pixel, m), intensity.tif (their mean intensity as
/// the sensor gives it) and density.tif (points of the map per m^2) as GeoTIFF with pixels of
/// `pixel` m: in the UTM zone of the datum, heights above the ellipsoid, or in the map frame
/// without one. Pixels without points are NaN (0 in density.tif). The points wait in unnamed files
/// in `directory`; a stripe of the raster is in memory at a time. Throws FileError, and InputError
/// for a map without points, a raster of more than 4e9 pixels, or a build without GDAL.
Files write_geotiff(const TileSource& tiles, const std::optional<GeodeticDatum>& datum,
                    double pixel, const std::filesystem::path& directory);

}  // namespace lidar_mapping::map
