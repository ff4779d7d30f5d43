// SPDX-License-Identifier: BSD-3-Clause
#include "drive_input.hpp"

#include <filesystem>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/folder_input.hpp"

#include "bag_input.hpp"
#include "bag_paths.hpp"
#include "pcd_scan.hpp"

namespace lidar_mapping::recordings {

namespace {

// s at the beginning that are checked before mapping starts; chosen as kValidationTime of the node.
constexpr double kCheckedTime = 5.0;

OpenDrive open_folder(const DriveSelection& selection,
                      const preprocessing::PreprocessingConfig& config) {
  pipeline::FolderOptions options;
  options.read_pcd = [config](const std::string& path, Stamp stamp) {
    return read_pcd_scan(path, stamp, config);
  };
  options.sensor_height = selection.sensor_height;
  auto folder = std::make_unique<pipeline::FolderInput>(selection.paths.front(), options);
  OpenDrive drive;
  drive.lines.push_back(folder->description());
  drive.paths = selection.paths;
  drive.input = std::move(folder);
  return drive;
}

/// "points    /topic: data", and the faults that were found.
std::vector<std::string> lines_about(const BagInput& bags) try {
  const std::vector<std::string> topics = bags.topics().by_sensor();
  std::vector<std::string> lines;
  if (!bags.frames_notice().empty()) lines.push_back("frames    " + bags.frames_notice());
  std::size_t index = 0;
  for (const preprocessing::InputReport& report : bags.examine(kCheckedTime)) {
    const std::string& topic = topics[index++];
    std::string name = report.input;
    name.resize(10, ' ');
    lines.push_back(name + topic + (topic.empty() ? "" : ": ") + report.found);
    for (const preprocessing::CheckDiagnostic& diagnostic : report.diagnostics) {
      lines.push_back("  " + std::string(to_string(diagnostic.severity)) + ": " +
                      sentence(diagnostic));
    }
  }
  return lines;
} catch (const FileError& error) {  // damage at the beginning must not prevent the mapping
  return {std::string("the recording was not checked: ") + error.what()};
}

OpenDrive open_bags(const DriveSelection& selection,
                    const preprocessing::PreprocessingConfig& config) {
  auto bags = make_bag_input(selection.paths, selection.topics, selection.base_frame, config);
  OpenDrive drive;
  drive.lines = lines_about(*bags);
  if (bags->topics().points.empty()) {
    std::string text = "there are no scans in " + selection.paths.front();
    for (const std::string& line : drive.lines) text += "\n" + line;
    throw InputError(text);
  }
  const ros_border::SensorTopics& topics = bags->topics();
  drive.topics = {{"points", topics.all_points()},
                  {"imu", topics.imu},
                  {"velocity", topics.velocity},
                  {"gnss", topics.gnss}};
  drive.paths = selection.paths;
  drive.input = std::move(bags);
  return drive;
}

}  // namespace

OpenDrive open_drive(const DriveSelection& given,
                     const preprocessing::PreprocessingConfig& config) {
  DriveSelection selection = given;
  selection.paths = with_bags_of_folders(given.paths);
  for (const std::string& path : selection.paths) {
    if (!std::filesystem::is_directory(path)) continue;
    if (selection.paths.size() == 1) return open_folder(selection, config);
    throw InputError(
        path + " is a folder without bags; several inputs must all be bags or folders of bags");
  }
  return open_bags(selection, config);
}

}  // namespace lidar_mapping::recordings
