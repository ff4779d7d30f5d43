// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/config/value.hpp"

// Overlays have a group of values for each stage, and priority over the files of the stages.
namespace lidar_mapping::config {

/// Throws ConfigError if the overlay has something else than groups of these names.
void check_groups(const Source& overlay, const std::vector<std::string>& names);

/// The group of that name, if the overlay has one.
std::optional<Source> part_of(const Source& overlay, const std::string& name);

}  // namespace lidar_mapping::config
