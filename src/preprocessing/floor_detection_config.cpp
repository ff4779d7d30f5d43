#include "lidar_mapping/preprocessing/floor_detection_config.hpp"

namespace lidar_mapping::preprocessing {

const config::Schema<FloorDetectionConfig>& FloorDetectionConfig::schema() {
  static const auto schema =
      config::Schema<FloorDetectionConfig>("floor_detection", "Parameters of floor_detection");
  return schema;
}

}  // namespace lidar_mapping::preprocessing
