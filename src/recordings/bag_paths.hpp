// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::recordings {

/// Replaces each folder that has bags by its bags (*.bag, or *.db3 or *.mcap of ROS 2, sorted by
/// name).
std::vector<std::string> with_bags_of_folders(const std::vector<std::string>& paths);

}  // namespace lidar_mapping::recordings
