// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/ros/cloud_reader.hpp"

namespace lidar_mapping::ros_border {

/// Why a LiDAR whose first cloud this is cannot be merged with others; empty if it can.
std::string merging_problem(const RecordedCloud& cloud, const CloudReader& reader);

}  // namespace lidar_mapping::ros_border
