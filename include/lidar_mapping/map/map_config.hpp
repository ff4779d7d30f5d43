#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::map {

/// Parameters of the stage; each is described once, in schema().
struct MapConfig {
  static const config::Schema<MapConfig>& schema();
};

}  // namespace lidar_mapping::map
