// SPDX-License-Identifier: BSD-3-Clause
#include "bag_paths.hpp"

#include <algorithm>
#include <filesystem>

namespace lidar_mapping::recordings {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> bags_in(const fs::path& folder) {
  std::vector<std::string> bags;
  std::error_code unreadable;  // reported when the folder is opened later
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    if (entry.is_regular_file() && entry.path().extension() == ".bag") bags.push_back(entry.path());
  }
  std::sort(bags.begin(), bags.end());
  return bags;
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
