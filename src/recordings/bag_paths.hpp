// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::recordings {

/// The paths with the bags (*.bag, by name) of a folder in the place of each folder that holds any.
std::vector<std::string> with_bags_of_folders(const std::vector<std::string>& paths);

}  // namespace lidar_mapping::recordings
