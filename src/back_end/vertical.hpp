// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Where the IMU saw "up" from a node.
struct Vertical {
  int node = 0;
  Eigen::Vector3d up_base = Eigen::Vector3d::UnitZ();
  double stddev = 1.0;  ///< rad
};

/// By the IMU's orientation and by its acceleration, as the configuration says. An acceleration
/// counts the less the more its length differs from gravity. REP 145 wants it upward at rest;
/// drivers that report it downward are recognised by the majority and turned round.
std::vector<Vertical> verticals(const DriveGraph& drive, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
