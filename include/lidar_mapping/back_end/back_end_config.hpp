#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::back_end {

/// Parameters of the stage; each is described once, in schema().
struct BackEndConfig {
  static const config::Schema<BackEndConfig>& schema();
};

}  // namespace lidar_mapping::back_end
