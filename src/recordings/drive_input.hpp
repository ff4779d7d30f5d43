// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/ros/recording_check.hpp"

namespace lidar_mapping::recordings {

/// Where a drive is, and what is to be read of it.
struct DriveSelection {
  std::vector<std::string> paths;  ///< bags, folders of bags, or one folder of scans
  ros_border::SensorTopics topics;
  std::string base_frame = "base_link";
  double sensor_height = 1.73;  ///< of folders, m
};

/// A drive that is open, and what is to be said of it before it is mapped.
struct OpenDrive {
  std::unique_ptr<pipeline::InputSource> input;
  std::vector<std::string> lines;
  std::vector<std::string> paths;             ///< bags, or the folder of scans
  std::map<std::string, std::string> topics;  ///< by sensor; empty for folders of scans
};

/// Opens bags or a folder and looks at the first seconds with the rules of check_bag. Throws
/// FileError and InputError.
OpenDrive open_drive(const DriveSelection& selection,
                     const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::recordings
