#include "lidar_mapping/front_end/front_end_config.hpp"

namespace lidar_mapping::front_end {

const config::Schema<FrontEndConfig>& FrontEndConfig::schema() {
  static const auto schema = config::Schema<FrontEndConfig>("front_end", "Parameters of front_end");
  return schema;
}

}  // namespace lidar_mapping::front_end
