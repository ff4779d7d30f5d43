#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::simulation {

/// A spinning LiDAR: what it looks at in a turn.
struct LidarModel {
  std::string name;
  std::vector<double> elevations;  ///< rad above the sensor's xy plane, highest beam first
  int columns = 0;                 ///< firings per turn
  double min_range = 0.0;          ///< m
  double max_range = 0.0;          ///< m
};

/// `hdl64`, `vlp16` or `os1_64`. Throws ConfigError for any other name.
LidarModel lidar_model(const std::string& name);
std::vector<std::string> lidar_names();

/// Azimuth of a column, rad: the turn begins behind the sensor and goes clockwise seen from above.
double column_azimuth(const LidarModel& model, int column);

}  // namespace lidar_mapping::simulation
