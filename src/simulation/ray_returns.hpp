#pragma once

#include <vector>

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {

/// What came back along one ray of a turn.
struct RayReturn {
  bool there = false;
  Point point;  ///< in the LiDAR's frame
  std::uint8_t moving = 0;
};

/// A scan as a table with an entry for each ray, column by column, from the highest beam down.
std::vector<RayReturn> returns_of(const SimulatedScan& scan, const LidarModel& lidar);
/// The scan of such a table: that of `scan`, with other points.
SimulatedScan scan_of(const std::vector<RayReturn>& returns, const SimulatedScan& scan,
                      const LidarModel& lidar);

/// Unit vector of each ray of such a table, in the LiDAR's frame.
std::vector<Eigen::Vector3d> ray_directions(const LidarModel& lidar);
/// When a column is fired, after the beginning of the turn.
Stamp column_delay(const LidarModel& lidar, Stamp period, int column);

}  // namespace lidar_mapping::simulation
