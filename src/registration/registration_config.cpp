#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::registration {

const config::Schema<RegistrationConfig>& RegistrationConfig::schema() {
  static const auto schema =
      config::Schema<RegistrationConfig>("registration", "Parameters of registration");
  return schema;
}

}  // namespace lidar_mapping::registration
