// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/pipeline/stored_configuration.hpp"

#include "parameters/config_path.hpp"

namespace lidar_mapping::tools {

/// Parameters of a drive, and over them those of a YAML file (empty: none), in growing priority.
template <typename Config>
std::vector<config::Source> drive_sources(const session::Session& drive, const std::string& file) {
  std::vector<config::Source> sources{pipeline::stored_configuration<Config>(drive)};
  if (!file.empty()) sources.push_back(config::read_yaml_file(file));
  return sources;
}

/// Parameters of a drive, overridden by the stage's file in --config. Throws FileError and
/// ConfigError.
template <typename Config>
Config drive_config(const session::Session& drive, const std::string& config) {
  return config::load<Config>(
      drive_sources<Config>(drive, stage_file(config, Config::schema().stage())));
}

}  // namespace lidar_mapping::tools
