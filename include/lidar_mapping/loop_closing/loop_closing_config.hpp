#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::loop_closing {

/// Parameters of the stage; each is described once, in schema().
struct LoopClosingConfig {
  static const config::Schema<LoopClosingConfig>& schema();
};

}  // namespace lidar_mapping::loop_closing
