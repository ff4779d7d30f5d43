// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::pipeline {

/// One file of oxts/data: what KITTI's GNSS/INS unit measures, in its own axes (x forward, y left,
/// z up).
struct OxtsSample {
  GnssFix fix;
  ImuSample imu;
  VelocitySample velocity;
};

/// Reads the dates of a timestamps.txt ("2011-09-26 13:02:25.967790592", as UTC). Throws FileError
/// with file and line.
std::vector<Stamp> read_kitti_dates(const std::filesystem::path& path);
/// Reads the samples of the folder oxts/. Throws FileError.
std::vector<OxtsSample> read_oxts(const std::filesystem::path& folder);
/// Reads a scan *.txt with x y z reflectance in each line. Throws FileError.
PointCloud read_text_scan(const std::filesystem::path& path);
/// Reads T_velo_imu from calib_imu_to_velo.txt; none if there is no such file. Throws FileError.
std::optional<Pose> read_imu_to_velo(const std::filesystem::path& path);

}  // namespace lidar_mapping::pipeline
