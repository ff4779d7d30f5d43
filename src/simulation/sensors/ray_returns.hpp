// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {

/// Return of one ray of a frame.
struct RayReturn {
  bool is_valid = false;
  Point point;  ///< Point in the frame of the LiDAR, m.
  std::uint8_t moving = 0;
};

/// A scan as a table with one entry per ray, in the order of ray_directions().
std::vector<RayReturn> returns_of(const SimulatedScan& scan, const LidarModel& lidar);
/// Converts such a table to a scan with the stamps of `scan`.
SimulatedScan scan_of(const std::vector<RayReturn>& returns, const SimulatedScan& scan,
                      const LidarModel& lidar);

}  // namespace lidar_mapping::simulation
