#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::front_end {

/// Parameters of the stage; each is described once, in schema().
struct FrontEndConfig {
  static const config::Schema<FrontEndConfig>& schema();
};

}  // namespace lidar_mapping::front_end
