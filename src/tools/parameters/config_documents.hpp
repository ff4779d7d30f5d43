// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::tools {

/// Documents about the parameters of one stage, made from its schema.
struct ConfigDocument {
  std::string stage;     ///< also the name of the file: config/<stage>.yaml
  std::string yaml;      ///< the shipped file: all fields with their defaults, and comments
  std::string markdown;  ///< the manual's table
};

/// One for each stage that has parameters.
std::vector<ConfigDocument> config_documents();

}  // namespace lidar_mapping::tools
