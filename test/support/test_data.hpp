// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace lidar_mapping::test {

/// Folder of a set of recorded scans, or an empty path where the recordings are not at hand.
/// LIDAR_MAPPING_TEST_DATA names the folder that holds all sets, unpacked.
inline std::filesystem::path recorded(const std::string& set) {
  const char* root = std::getenv("LIDAR_MAPPING_TEST_DATA");
  if (root == nullptr) return {};
  const std::filesystem::path folder = std::filesystem::path(root) / set;
  return std::filesystem::is_directory(folder) ? folder : std::filesystem::path();
}

}  // namespace lidar_mapping::test

/// Ends the test as skipped where the recordings are not at hand.
#define REQUIRE_RECORDED(folder, set)                                      \
  const std::filesystem::path folder = lidar_mapping::test::recorded(set); \
  if (folder.empty())                                                      \
  GTEST_SKIP() << "recordings of " << set << " are not here; set LIDAR_MAPPING_TEST_DATA"
