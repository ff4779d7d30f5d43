// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/pipeline/pipeline_config.hpp"

namespace lidar_mapping::tools {

/// The parameters of all stages, with the values that the nodes would use.
struct StageFiles {
  pipeline::PipelineConfig pipeline;
  map::MapConfig map;
  std::string base_frame = "base_link";
  std::map<std::string, std::string> texts;  ///< of each stage, all fields as YAML
  std::vector<std::string> replaced;  ///< lines about values of files that overlays have replaced
};

/// Sources of parameters; later ones have priority over earlier ones.
struct ParameterSources {
  std::string config;   ///< folder of <stage>.yaml files or one of them; empty: defaults
  std::string overlay;  ///< a name in config/sensors, or the path of a file; empty: none
  std::string preset;   ///< the same in config/presets; has priority over that of the sensor
  std::vector<std::string> parameters;  ///< single ones, as "stage/name: value"
};

/// Reads the parameters of all stages, as the launch file does. Parameters that only the nodes have
/// are ignored. Throws ConfigError and FileError.
StageFiles read_stage_files(const ParameterSources& sources);

}  // namespace lidar_mapping::tools
