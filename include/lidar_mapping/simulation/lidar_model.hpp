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
  kSpinning,  ///< The beams turn about the z axis of the sensor; all frames are alike.
  kSwinging,  ///< The beams turn and swing up and down; all frames differ (Livox Mid-360).
  kRosette,   ///< Two prisms deflect the beams; all frames differ (Livox Avia).
  kRaster  ///< A mirror guides the beams line by line through a field ahead; all frames are alike.
};

/// Model of a LiDAR: the directions of its rays. A frame has `columns` instants at equal distances,
/// and at each of them `beams` rays are fired together.
struct LidarModel {
  std::string name;  ///< One of lidar_names().
  /// Only of spinning LiDARs: angles of the beams above the xy plane of the sensor, rad, highest
  /// first.
  std::vector<double> elevations;
  int columns = 0;                               ///< Firings per frame.
  double min_range = 0.0;                        ///< Least range that is measured, m.
  double max_range = 0.0;                        ///< Largest range that is measured, m.
  ScanPattern pattern = ScanPattern::kSpinning;  ///< Motion of the beams.
  int beams = 0;                                 ///< Rays per firing.

  /// Rays per frame.
  std::size_t ray_count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(beams);
  }
};

/// The model of this name, one of lidar_names(). Throws ConfigError for any other name.
LidarModel lidar_model(const std::string& name);
/// Names of all models.
std::vector<std::string> lidar_names();

/// Azimuth of a column of a spinning LiDAR, rad. The turn begins behind the sensor and goes
/// clockwise as seen from above.
double column_azimuth(const LidarModel& model, int column);

/// Unit vector of each ray of a frame in the frame of the LiDAR, column by column. `frame` counts
/// from the beginning of the drive.
std::vector<Eigen::Vector3d> ray_directions(const LidarModel& model, std::size_t frame);
/// Time from the beginning of a frame to the firing of a column, ns; the frame takes `period`.
Stamp column_delay(const LidarModel& model, Stamp period, int column);

}  // namespace lidar_mapping::simulation
