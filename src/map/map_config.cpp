#include "lidar_mapping/map/map_config.hpp"

namespace lidar_mapping::map {

const config::Schema<MapConfig>& MapConfig::schema() {
  static const auto schema = config::Schema<MapConfig>("map", "Parameters of map");
  return schema;
}

}  // namespace lidar_mapping::map
