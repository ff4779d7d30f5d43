// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lidar_mapping/ros/scratch_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

namespace fs = std::filesystem;

/// The number of a process that has ended.
pid_t ended_process() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

TEST(ScratchFolder, GoesWithItsObject) {
  fs::path path;
  {
    const ScratchFolder folder("ns/node");
    path = folder.path();
    std::ofstream(path / "file") << "x";
    EXPECT_TRUE(fs::is_directory(path));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(ScratchFolder, RemovesWhatAKilledProcessLeftAndNothingElse) {
  const fs::path parent = fs::temp_directory_path();
  const fs::path left = parent / ("lidar_mapping-test_a-" + std::to_string(ended_process()));
  const fs::path running = parent / ("lidar_mapping-test_a-" + std::to_string(getppid()));
  const fs::path foreign = parent / "lidar_mapping-test_a-notes";
  for (const fs::path& path : {left, running, foreign}) fs::create_directory(path);
  { const ScratchFolder folder("test_a"); }
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(running));
  EXPECT_TRUE(fs::exists(foreign));
  fs::remove(running);
  fs::remove(foreign);
}

TEST(ScratchFolder, IsEmptyAlsoIfAKilledProcessHadTheSameNumber) {
  const fs::path left =
      fs::temp_directory_path() / ("lidar_mapping-test_b-" + std::to_string(getpid()));
  fs::create_directory(left);
  std::ofstream(left / "file") << "x";
  const ScratchFolder folder("test_b");
  EXPECT_EQ(folder.path(), left);
  EXPECT_TRUE(fs::is_empty(left));
}

}  // namespace
}  // namespace lidar_mapping::ros_border
