// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {

/// What came back along one ray of a frame.
struct RayReturn {
  bool there = false;
  Point point;  ///< in the LiDAR's frame
  std::uint8_t moving = 0;
};

/// A scan as a table with an entry for each ray, in the order of ray_directions().
std::vector<RayReturn> returns_of(const SimulatedScan& scan, const LidarModel& lidar);
/// The scan of such a table: that of `scan`, with other points.
SimulatedScan scan_of(const std::vector<RayReturn>& returns, const SimulatedScan& scan,
                      const LidarModel& lidar);

}  // namespace lidar_mapping::simulation
