// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/localization/localizer.hpp"

namespace lidar_mapping::report {

/// A scan of a drive that was localised in a map.
struct ExaminedScan {
  Stamp stamp = 0;
  localization::LocalizationState state = localization::LocalizationState::kSearching;
  Pose T_map_base;            ///< if the state has a pose
  Pose T_odom_base;           ///< by the drive's own odometry
  std::uint32_t segment = 0;  ///< odometry leads from scan to scan within one
  double path = 0.0;          ///< by odometry since the first scan, m
  double agreement = 0.0;     ///< with the map, 0 to 1
  double coverage = 0.0;      ///< by the map, 0 to 1
  std::string reason;         ///< one sentence about the state
};

/// A drive that localize_bag has localised in a map, to examine the map by it.
struct ExaminedDrive {
  std::string name;                     ///< of the folder of localize_bag
  std::vector<std::string> recordings;  ///< names of its bags or folders of scans
  std::vector<ExaminedScan> scans;      ///< by increasing stamp, at least one
};

/// The scans in a folder of localize_bag (localization.csv and the trajectory by odometry). Throws
/// FileError, and InputError with file, line and remedy if they are damaged.
std::vector<ExaminedScan> read_examined_scans(const std::filesystem::path& folder);

/// The drive in a folder of localize_bag. `map` holds the newest poses of the session in the folder
/// `session`. Throws InputError, too, if the drive was localised in another map or in earlier poses
/// of it, or if the map was made from this drive.
ExaminedDrive read_examined_drive(const std::filesystem::path& folder, const KeyFramePoses& map,
                                  const std::filesystem::path& session);

}  // namespace lidar_mapping::report
