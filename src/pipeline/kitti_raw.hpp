// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::pipeline {

/// One line of oxts/data: what KITTI's GNSS/INS says, in its own axes (x forward, y left, z up).
struct OxtsSample {
  GnssFix fix;
  ImuSample imu;
  VelocitySample velocity;
};

/// The dates of a timestamps.txt ("2011-09-26 13:02:25.967790592", taken as UTC). Throws FileError
/// naming file and line.
std::vector<Stamp> read_kitti_dates(const std::filesystem::path& path);
/// Samples of the folder oxts/. Throws FileError.
std::vector<OxtsSample> read_oxts(const std::filesystem::path& folder);
/// A scan as *.txt: x y z reflectance a line. Throws FileError.
PointCloud read_text_scan(const std::filesystem::path& path);
/// T_velo_imu of calib_imu_to_velo.txt; none if there is no such file. Throws FileError.
std::optional<Pose> read_imu_to_velo(const std::filesystem::path& path);

}  // namespace lidar_mapping::pipeline
