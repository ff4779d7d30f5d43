#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::preprocessing {

/// Parameters of the stage; each is described once, in schema().
struct PreprocessingConfig {
  static const config::Schema<PreprocessingConfig>& schema();
};

}  // namespace lidar_mapping::preprocessing
