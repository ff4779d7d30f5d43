#include "lidar_mapping/back_end/back_end_config.hpp"

namespace lidar_mapping::back_end {

const config::Schema<BackEndConfig>& BackEndConfig::schema() {
  static const auto schema = config::Schema<BackEndConfig>("back_end", "Parameters of back_end");
  return schema;
}

}  // namespace lidar_mapping::back_end
