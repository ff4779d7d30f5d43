// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/pipeline/map_extender.hpp"

namespace lidar_mapping::pipeline {

/// What became of the extension of a map, as lines for a person: what was added, or that no session
/// is written; what was left out and why, if anything was; how far the map moved, if there is a
/// session.
std::vector<std::string> extension_lines(const ExtensionReport& report);

}  // namespace lidar_mapping::pipeline
