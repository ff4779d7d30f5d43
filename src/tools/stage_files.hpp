#pragma once

#include <map>
#include <string>

#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/pipeline/pipeline_config.hpp"

namespace lidar_mapping::tools {

/// The parameters of all stages, as the nodes would have them.
struct StageFiles {
  pipeline::PipelineConfig pipeline;
  map::MapConfig map;
  std::string base_frame = "base_link";
  std::map<std::string, std::string> texts;  ///< of each stage, all fields as YAML
};

/// Reads <stage>.yaml of `folder` (empty, or a file that is not there: defaults), then the parts of
/// `overlay` (empty: none) as the launch file does: a name in config/sensors, or the path of a
/// file. What only nodes need is passed over. Throws ConfigError and FileError.
StageFiles read_stage_files(const std::string& folder, const std::string& overlay);

}  // namespace lidar_mapping::tools
