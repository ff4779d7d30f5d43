// SPDX-License-Identifier: BSD-3-Clause
#include "parameters/config_documents.hpp"

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::tools {

namespace {

template <typename Config>
ConfigDocument document_of() {
  return {Config::schema().stage(), config::to_yaml(Config()), config::to_markdown<Config>()};
}

}  // namespace

std::vector<ConfigDocument> config_documents() {
  return {document_of<preprocessing::PreprocessingConfig>(),
          document_of<preprocessing::FloorDetectionConfig>(),
          document_of<front_end::FrontEndConfig>(),
          document_of<loop_closing::LoopClosingConfig>(),
          document_of<back_end::BackEndConfig>(),
          document_of<map::MapConfig>()};
}

}  // namespace lidar_mapping::tools
