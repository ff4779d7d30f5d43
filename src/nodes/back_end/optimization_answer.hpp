// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/back_end/pose_change.hpp"
#include "lidar_mapping/ros/messages.hpp"

namespace lidar_mapping::ros_border {

/// Effects of a requested optimisation on the map.
struct MapOptimization {
  back_end::OptimizationReport report;
  back_end::PoseChange moved;      ///< by this optimisation
  back_end::PoseChange corrected;  ///< from odometry alone
  Stamp begin = 0;                 ///< of the first key frame
  std::string session;             ///< its folder
  std::string save_map;            ///< name of the service that writes the map
};

/// The answer of optimize_map: figures, and sentences for the user.
OptimizeMap::Response to_answer(const MapOptimization& optimization);

}  // namespace lidar_mapping::ros_border
