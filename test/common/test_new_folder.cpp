// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include <gtest/gtest.h>

#include "lidar_mapping/common/new_folder.hpp"

namespace lidar_mapping {
namespace {

namespace fs = std::filesystem;

TEST(FolderPath, EndsWithTheNameOfTheFolder) {
  for (const char* path : {"/a/b", "/a/b/", "/a/b/.", "/a/c/../b", "/a/b/c/.."}) {
    EXPECT_EQ(folder_path(path).string(), "/a/b") << path;
  }
  EXPECT_EQ(folder_path("b/").string(), (fs::current_path() / "b").string());
  EXPECT_EQ(folder_path(".").string(), fs::current_path().string());
  EXPECT_EQ(folder_path("/").string(), "/");
}

TEST(HiddenBeside, IsInTheSameFolderAndBeginsWithAPoint) {
  for (const char* path : {"/a/b", "/a/b/", "/a/b/."}) {
    EXPECT_EQ(hidden_beside(path, ".part").string(), "/a/.b.part") << path;
  }
}

}  // namespace
}  // namespace lidar_mapping
