// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/map_config.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::map {

const config::Schema<MapConfig>& MapConfig::schema() {
  static const auto schema =
      config::Schema<MapConfig>("map", "The map that the clouds of the key frames are joined to")
          .real("resolution", &MapConfig::resolution, {0.01, 10.0}, "m",
                "Edge of the map's voxels; each gives one point, its centroid.")
          .real("tile_size", &MapConfig::tile_size, {5.0, 1000.0}, "m",
                "Edge of the squares in which the map is built and rebuilt.")
          .real("grid_cell", &MapConfig::grid_cell, {0.0, 10.0}, "m",
                "Edge of the cells of the 2D grid, not less than that of the voxels; 0 takes that.")
          .real(
              "rebuild_distance", &MapConfig::rebuild_distance, {0.0, 10.0}, "m",
              "A key frame is put in again when a point 50 m away from it moved by more; 0 always.")
          .integer("threads", &MapConfig::threads, {0, 256}, "",
                   "Upper limit of threads; 0 takes all cores. The result does not depend on it.")
          .alias("map_cloud_resolution", "resolution")
          .alias("voxel_filter/global_map/leaf_size", "resolution");
  return schema;
}

double grid_cell(const MapConfig& config) {
  if (config.grid_cell == 0.0) return config.resolution;
  if (config.grid_cell >= config.resolution) return config.grid_cell;
  throw InputError(
      formatted("cells of %g m are smaller than the map's voxels of %g m, and walls would have "
                "gaps; choose larger cells or a finer resolution",
                config.grid_cell, config.resolution));
}

}  // namespace lidar_mapping::map
