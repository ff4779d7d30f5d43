// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::map {

/// Parameters of the stage; each is described once, in schema().
struct MapConfig {
  /// [m] Edge of the map's voxels; each gives one point, its centroid.
  double resolution = 0.2;
  /// [m] Edge of the squares in which the map is built and rebuilt.
  double tile_size = 50.0;
  /// [m] Edge of the cells of the 2D grid, not less than that of the voxels; 0 takes that.
  double grid_cell = 0.0;
  /// [m] A key frame is put in again when a point 50 m away from it moved by more; 0 always.
  double rebuild_distance = 0.05;
  /// Upper limit of threads; 0 takes all cores. The result does not depend on it.
  int threads = 0;

  /// Names, units, ranges and descriptions of the parameters.
  static const config::Schema<MapConfig>& schema();
};

/// Edge of the cells of the 2D grid in m, with 0 replaced by the edge of the voxels. Throws
/// InputError if the cells would be smaller than the voxels.
double grid_cell(const MapConfig& config);

}  // namespace lidar_mapping::map
