// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::pipeline {

/// Corrections that are applied to the points of a folder while they are read.
struct KittiReadOptions {
  /// Rotates every point upwards by this angle (rad) about the horizontal axis across its beam. The
  /// sensor of KITTI reports elevations about 0.2 degrees too low.
  double elevation_correction = 0.0;
  /// Computes the times of the points from their azimuths, for raw scans without times: the sensor
  /// turns clockwise once in kKittiTurn and looks straight ahead at the stamp.
  bool time_from_azimuth = false;
};

/// Duration of one turn of KITTI's sensor, s, by the stamps of its odometry benchmark.
constexpr double kKittiTurn = 0.104;

/// Scans in a folder with KITTI's layout: velodyne/NNNNNN.bin (float32 x y z intensity) and, where
/// they exist, times.txt (seconds, a line per scan; else 10 Hz) and point_times/NNNNNN.f32 (float32
/// seconds after the stamp of the scan, one per point). Scans are in the frame of the LiDAR.
class KittiFolder {
 public:
  /// Throws FileError if there are no scans, or fewer times than scans.
  explicit KittiFolder(const std::string& path, const KittiReadOptions& options = {});

  /// Number of scans.
  std::size_t size() const { return scans_.size(); }
  /// Stamp of a scan, ns; `index` is less than size().
  Stamp stamp(std::size_t index) const { return stamps_[index]; }
  /// Reads a scan; `index` is less than size(). Throws FileError with the name of the file if it
  /// cannot be read or its length is not a multiple of the size of a point.
  Scan scan(std::size_t index) const;

 private:
  std::string path_;
  KittiReadOptions options_;
  std::vector<std::string> scans_;  ///< File names without folder and extension, in order.
  std::vector<Stamp> stamps_;
};

/// Reads a times.txt: seconds, one number per scan. Throws FileError with the number of the entry
/// that is not a time.
std::vector<Stamp> read_times(const std::filesystem::path& path);

/// Reads the points of a .bin file. Throws FileError like KittiFolder::scan().
std::vector<Point> read_points(const std::string& path);

}  // namespace lidar_mapping::pipeline
