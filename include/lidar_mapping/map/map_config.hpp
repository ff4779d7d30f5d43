#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::map {

/// Parameters of the stage; each is described once, in schema().
struct MapConfig {
  double resolution = 0.2;
  double tile_size = 50.0;
  double rebuild_distance = 0.05;
  int threads = 0;

  static const config::Schema<MapConfig>& schema();
};

}  // namespace lidar_mapping::map
