// SPDX-License-Identifier: BSD-3-Clause
#include "bag_paths.hpp"

#include <filesystem>
#include <system_error>

#include "lidar_mapping/common/folder_entries.hpp"

namespace lidar_mapping::recordings {

namespace {

namespace fs = std::filesystem;

/// The parts of a recording of ROS 2 are numbered: drive_0.db3, drive_1.db3 ... Those that are not
/// read are named, so that opening them says why.
std::vector<std::string> bags_in(const fs::path& folder) {
  std::error_code unreadable;  // reported when the folder is opened later
  fs::directory_iterator(folder, unreadable);
  if (unreadable) return {};
  for (const char* extension : {".bag", ".db3", ".mcap", ".zstd"}) {
    const auto files = sorted_paths_in(folder, [&](const fs::directory_entry& entry) {
      return entry.is_regular_file() && entry.path().extension() == extension;
    });
    if (!files.empty()) return {files.begin(), files.end()};
  }
  return {};
}

}  // namespace

std::vector<std::string> with_bags_of_folders(const std::vector<std::string>& paths) {
  std::vector<std::string> result;
  for (const std::string& path : paths) {
    const std::vector<std::string> bags =
        fs::is_directory(path) ? bags_in(path) : std::vector<std::string>();
    if (bags.empty()) {
      result.push_back(path);
    } else {
      result.insert(result.end(), bags.begin(), bags.end());
    }
  }
  return result;
}

}  // namespace lidar_mapping::recordings
