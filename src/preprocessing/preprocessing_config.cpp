#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

const config::Schema<PreprocessingConfig>& PreprocessingConfig::schema() {
  static const auto schema =
      config::Schema<PreprocessingConfig>("preprocessing", "Parameters of preprocessing");
  return schema;
}

}  // namespace lidar_mapping::preprocessing
