// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/folder_entries.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping {
namespace {

namespace fs = std::filesystem;

TEST(SortedPathsIn, AreTheWantedOnesByName) {
  const test::TemporaryFolder folder;
  for (const char* name : {"10.bin", "2.bin", "1.bin", "notes.txt"}) {
    std::ofstream(folder.path() / name) << "content";
  }
  fs::create_directory(folder.path() / "0.bin");
  const auto is_bin = [](const fs::directory_entry& entry) {
    return entry.path().extension() == ".bin";
  };
  const auto in_folder = [&](const char* name) { return folder.path() / name; };
  const std::vector<fs::path> all = {in_folder("0.bin"), in_folder("1.bin"), in_folder("2.bin"),
                                     in_folder("10.bin")};
  EXPECT_EQ(sorted_paths_in(folder.path(), is_bin), all);
  const auto none = [](const fs::directory_entry&) { return false; };
  EXPECT_TRUE(sorted_paths_in(folder.path(), none).empty());
}

TEST(SortedPathsIn, NeedAFolder) {
  const test::TemporaryFolder folder;
  const auto all = [](const fs::directory_entry&) { return true; };
  EXPECT_TRUE(sorted_paths_in(folder.path(), all).empty());
  EXPECT_THROW(sorted_paths_in(folder.path() / "missing", all), fs::filesystem_error);
}

}  // namespace
}  // namespace lidar_mapping
