#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::map {

/// Parameters of the stage; each is described once, in schema().
struct MapConfig {
  double resolution = 0.2;
  double tile_size = 50.0;
  double grid_cell = 0.0;
  double rebuild_distance = 0.05;
  int threads = 0;

  static const config::Schema<MapConfig>& schema();
};

/// Edge of the cells of the 2D grid, m. Throws InputError where they would be smaller than the
/// voxels.
double grid_cell(const MapConfig& config);

}  // namespace lidar_mapping::map
