// SPDX-License-Identifier: BSD-3-Clause
#include "parameters/config_path.hpp"

#include <filesystem>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::tools {

namespace fs = std::filesystem;

std::string stage_file(const std::string& config, const std::string& stage) {
  if (config.empty()) return "";
  if (fs::is_directory(config)) {
    const fs::path file = fs::path(config) / (stage + ".yaml");
    return fs::exists(file) ? file.string() : "";
  }
  if (!fs::exists(config)) {
    throw FileError("no folder or file " + config + "; --config names a " + kConfigHelp);
  }
  return fs::path(config).stem() == stage ? config : "";
}

std::string only_stage_file(const std::string& config, const std::string& stage) {
  if (config.empty() || fs::is_regular_file(config)) return config;
  const std::string file = stage_file(config, stage);
  if (!file.empty()) return file;
  throw FileError("there is no " + stage + ".yaml in " + config + "; --config names a " +
                  kConfigHelp);
}

}  // namespace lidar_mapping::tools
