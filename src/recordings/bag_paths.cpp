// SPDX-License-Identifier: BSD-3-Clause
#include "bag_paths.hpp"

#include <algorithm>
#include <filesystem>

namespace lidar_mapping::recordings {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const fs::path& folder, const std::string& extension) {
  std::vector<std::string> files;
  std::error_code unreadable;  // reported when the folder is opened later
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    const bool fits = entry.path().extension() == extension;
    if (entry.is_regular_file() && fits) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The parts of a recording of ROS 2 are numbered: drive_0.db3, drive_1.db3 ... Those that are not
/// read are named, so that opening them says why.
std::vector<std::string> bags_in(const fs::path& folder) {
  for (const char* extension : {".bag", ".db3", ".mcap", ".zstd"}) {
    std::vector<std::string> files = files_in(folder, extension);
    if (!files.empty()) return files;
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
