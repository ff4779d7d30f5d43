// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// The direction of the vertical that the IMU measured at a node.
struct Vertical {
  int node = 0;
  Eigen::Vector3d up_base = Eigen::Vector3d::UnitZ();
  double stddev = 1.0;  ///< of the direction, rad
};

/// Verticals by the IMU's orientation and by its acceleration, as configured. An acceleration has
/// less weight the more its length differs from gravity. By REP 145 it points upwards at rest; if
/// most accelerations of a driver point downwards, their sign is changed.
std::vector<Vertical> verticals(const DriveGraph& drive, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
