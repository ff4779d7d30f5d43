// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::simulation {

/// How the beams of a LiDAR move.
enum class ScanPattern {
  kSpinning,  ///< the beams turn about the sensor's z axis; every frame is alike
  kSwinging,  ///< they turn and swing up and down; no frame is like another (Livox Mid-360)
  kRosette,   ///< two prisms bend them; no frame is like another (Livox Avia)
  kRaster     ///< a mirror leads them line by line through a field ahead; every frame is alike
};

/// A LiDAR: what it looks at in a frame. A frame has `columns` instants at equal distances, at each
/// of which `beams` rays are fired together.
struct LidarModel {
  std::string name;
  std::vector<double> elevations;  ///< spinning: rad above the sensor's xy plane, highest first
  int columns = 0;
  double min_range = 0.0;  ///< m
  double max_range = 0.0;  ///< m
  ScanPattern pattern = ScanPattern::kSpinning;
  int beams = 0;

  std::size_t ray_count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(beams);
  }
};

/// One of lidar_names(). Throws ConfigError for any other name.
LidarModel lidar_model(const std::string& name);
std::vector<std::string> lidar_names();

/// Azimuth of a column of a spinning LiDAR, rad: the turn begins behind the sensor and goes
/// clockwise seen from above.
double column_azimuth(const LidarModel& model, int column);

/// Unit vector of each ray of a frame in the LiDAR's frame, column by column.
std::vector<Eigen::Vector3d> ray_directions(const LidarModel& model, std::size_t frame);
/// When a column is fired, after the beginning of a frame that takes `period`.
Stamp column_delay(const LidarModel& model, Stamp period, int column);

}  // namespace lidar_mapping::simulation
