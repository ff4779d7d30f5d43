// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "lidar_mapping/ros/topic_choice.hpp"

namespace lidar_mapping::ros_border {

/// Whether this package publishes the topic, in any namespace.
inline bool is_own_output(const std::string& topic) {
  const std::vector<std::string>& own = own_outputs();
  const std::string name = topic.substr(topic.find_last_of('/') + 1);
  return std::find(own.begin(), own.end(), name) != own.end();
}

}  // namespace lidar_mapping::ros_border
