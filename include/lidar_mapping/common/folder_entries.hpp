// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <filesystem>
#include <vector>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping {

/// Paths of what lies in a folder, sorted by name as by in_order_of_numbers(), because a folder
/// gives them in any order.
/// `fits(entry)` says of a std::filesystem::directory_entry whether it is wanted. Throws
/// std::filesystem::filesystem_error for a folder that cannot be read.
template <typename Fits>
std::vector<std::filesystem::path> sorted_paths_in(const std::filesystem::path& folder,
                                                   const Fits& fits) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (fits(entry)) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) {
    return in_order_of_numbers(a.filename().string(), b.filename().string());
  });
  return paths;
}

}  // namespace lidar_mapping
