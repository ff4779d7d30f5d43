// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::preprocessing {

/// Where a laser of a Velodyne looks and how its measurements are corrected, as the calibration
/// files of velodyne_pointcloud (ROS) have it, under the names there.
struct LaserCorrection {
  double rot_correction = 0.0;           ///< rad; turned counterclockwise, from above
  double vert_correction = 0.0;          ///< rad; elevation above the sensor's plane
  double dist_correction = 0.0;          ///< m; added to the range, far away
  double dist_correction_x = 0.0;        ///< m; added near by, to the side
  double dist_correction_y = 0.0;        ///< m; added near by, ahead
  bool has_two_points = false;           ///< whether the two before are to be used
  double vert_offset_correction = 0.0;   ///< m; the laser is so much higher than the origin
  double horiz_offset_correction = 0.0;  ///< m; the laser is so much to the left of the origin
  double min_intensity = 0.0;            ///< smallest intensity that is given
  double max_intensity = 255.0;          ///< largest intensity that is given
  double focal_distance = 0.0;           ///< where the laser's focus is, in units of the maker
  double focal_slope = 0.0;              ///< how intensities depend on the distance from there
};

/// Of all lasers of a sensor.
struct VelodyneCalibration {
  std::vector<LaserCorrection> lasers;  ///< by the numbers of the lasers in a packet
  double distance_resolution = 0.002;   ///< m of a count of the range
};

/// Reads a calibration file of velodyne_pointcloud (YAML, for 16, 32 or 64 lasers). Throws
/// FileError if it cannot be read, and ConfigError naming the laser and the entry that is wrong.
VelodyneCalibration read_velodyne_calibration(const std::string& path);

}  // namespace lidar_mapping::preprocessing
