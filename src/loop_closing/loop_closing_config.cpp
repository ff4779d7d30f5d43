#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

const config::Schema<LoopClosingConfig>& LoopClosingConfig::schema() {
  static const auto schema =
      config::Schema<LoopClosingConfig>("loop_closing", "Parameters of loop_closing");
  return schema;
}

}  // namespace lidar_mapping::loop_closing
