// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::pipeline {

/// What is done to the points of a folder while they are read.
struct KittiReading {
  /// Turns every point upward by this angle (rad) about the horizontal axis across its beam: the
  /// sensor of KITTI reports elevations about 0.2 degrees too low.
  double elevation_correction = 0.0;
  /// Times from the azimuth, for raw scans without times: the sensor turns clockwise once in
  /// kKittiTurn and looks straight ahead at the stamp.
  bool time_from_azimuth = false;
};

/// Seconds of one turn of KITTI's sensor.
constexpr double kKittiTurn = 0.104;

/// Scans in a folder as KITTI lays it out: velodyne/NNNNNN.bin (float32 x y z intensity), and where
/// they exist times.txt (seconds, a line per scan; else 10 Hz) and point_times/NNNNNN.f32 (float32
/// seconds after the scan's stamp, one per point). Scans are in the LiDAR's frame.
class KittiFolder {
 public:
  /// Throws FileError if there are no scans, or fewer times than scans.
  explicit KittiFolder(const std::string& path, const KittiReading& reading = {});

  std::size_t size() const { return scans_.size(); }
  Stamp stamp(std::size_t index) const { return stamps_[index]; }
  /// Throws FileError naming the file if it cannot be read or its length is no multiple of a point.
  Scan scan(std::size_t index) const;

 private:
  std::string path_;
  KittiReading reading_;
  std::vector<std::string> scans_;  ///< names without folder and ending, in order
  std::vector<Stamp> stamps_;
};

/// A times.txt: seconds, one per scan. Throws FileError with the place of what is none.
std::vector<Stamp> read_times(const std::filesystem::path& path);

/// The points of a .bin file. Throws FileError as KittiFolder::scan() does.
std::vector<Point> read_points(const std::string& path);

/// The point turned upward by `angle` (rad) about the horizontal axis across its beam.
Point raised(const Point& point, double angle);

}  // namespace lidar_mapping::pipeline
