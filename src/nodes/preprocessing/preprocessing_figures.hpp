// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/diagnostics.hpp"
#include "lidar_mapping/ros/ouster_feed.hpp"

namespace lidar_mapping::ros_border {

/// What preprocessing_node has counted since its start.
struct PreprocessingFigures {
  preprocessing::PreprocessingCounters counters;
  OusterLosses packets;                   ///< packets of an Ouster that are in no cloud
  std::size_t damaged_packets = 0;        ///< left out of the clouds that are made of packets
  std::size_t other_clouds_left_out = 0;  ///< of other LiDARs, without times or transform
};

/// Sets the figures, and the state: a warning with the numbers and reasons of what is left out.
void show(const PreprocessingFigures& figures, Diagnostics& diagnostics);

}  // namespace lidar_mapping::ros_border
