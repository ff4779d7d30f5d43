// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/ros/recording_check.hpp"

namespace lidar_mapping::recordings {

/// Paths, topics and frames of a drive that is to be read.
struct DriveSelection {
  std::vector<std::string> paths;  ///< bags, folders of bags, or one folder of scans
  ros_border::SensorTopics topics;
  std::string base_frame = "base_link";
  double sensor_height = 1.73;  ///< height of the LiDAR over base_link for folders of scans, m
};

/// An open drive, and messages about it for the user.
struct OpenDrive {
  std::unique_ptr<pipeline::InputSource> input;
  std::vector<std::string> lines;
  std::vector<std::string> paths;             ///< bags, or the folder of scans
  std::map<std::string, std::string> topics;  ///< by sensor; empty for folders of scans
};

/// Opens bags or a folder and checks the first seconds with the rules of check_bag. Throws
/// FileError and InputError.
OpenDrive open_drive(const DriveSelection& selection,
                     const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::recordings
