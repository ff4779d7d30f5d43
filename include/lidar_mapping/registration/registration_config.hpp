#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::registration {

/// Parameters of the stage; each is described once, in schema().
struct RegistrationConfig {
  static const config::Schema<RegistrationConfig>& schema();
};

}  // namespace lidar_mapping::registration
