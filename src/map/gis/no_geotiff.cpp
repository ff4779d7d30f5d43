// SPDX-License-Identifier: BSD-3-Clause
// In place of geotiff_files.cpp where GDAL is not installed at build time.
#include "lidar_mapping/common/errors.hpp"

#include "gis/geotiff_files.hpp"

namespace lidar_mapping::map {

std::string geotiff_obstacle() {
  return "this program was built without GDAL; install libgdal-dev and build again";
}

Files write_geotiff(const TileSource&, const std::optional<GeodeticDatum>&, double,
                    const std::filesystem::path&) {
  throw InputError(geotiff_obstacle());
}

}  // namespace lidar_mapping::map
