// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"

#include "error_text.hpp"
#include "stored_voxels.hpp"
#include "surface_tiles.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::localization::test {
namespace {

namespace fs = std::filesystem;
using lidar_mapping::test::error_text;
using lidar_mapping::test::TemporaryFolder;
using registration::GaussianVoxelMap;
using registration::VoxelSums;

constexpr int kSteps = 200;             // of a drive
constexpr int kStep = 3;                // m
constexpr double kRadius = 2.0;         // m
constexpr std::size_t kPoints = 60;     // at each step
constexpr std::size_t kFewSlots = 256;  // the whole drive has 2400 voxels
constexpr std::size_t kAll = std::size_t{1} << 20;

SurfaceTiles::Options tiles_of_four_metres(std::size_t most_slots) {
  SurfaceTiles::Options options;
  options.tile_edge = 4;
  options.first_slots = 16;
  options.most_slots = most_slots;
  return options;
}

/// Points around (x, 0), relative to the origin of the map.
struct Cloud {
  std::vector<float> x, y, z;
};

Cloud cloud_around(int x, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> beside(-1.99F, 1.99F);
  std::uniform_real_distribution<float> up(0.0F, 0.99F);
  Cloud cloud;
  for (std::size_t i = 0; i < kPoints; ++i) {
    cloud.x.push_back(static_cast<float>(x) + beside(engine));
    cloud.y.push_back(beside(engine));
    cloud.z.push_back(up(engine));
  }
  return cloud;
}

/// A drive along x to both sides of a point at `origin` metres.
class Drive {
 public:
  explicit Drive(int origin) : origin_(origin) {}

  static int x_at(int step) { return kStep * (step - kSteps / 2); }
  /// Each drive sees other points of the same surfaces.
  void insert(int step, std::uint32_t drive, SurfaceTiles& tiles) const {
    const int x = x_at(step);
    const Cloud cloud = cloud_around(x, 1000 * drive + static_cast<std::uint32_t>(step));
    const Eigen::Vector3f viewpoint(static_cast<float>(x), 0.0F, 5.0F);
    tiles.voxels().set_origin_cell({origin_, 0, 0});
    tiles.insert(position(step), kRadius, cloud.x.data(), cloud.y.data(), cloud.z.data(), kPoints,
                 viewpoint);
    tiles.voxels().update_planes(cloud.x.data(), cloud.y.data(), cloud.z.data(), kPoints,
                                 viewpoint);
  }
  void insert_all(SurfaceTiles& tiles) const {
    for (const std::uint32_t drive : {1U, 2U}) {
      for (int step = 0; step < kSteps; ++step) insert(step, drive, tiles);
    }
  }
  /// What is stored around a step.
  std::map<VoxelKey, std::string> required(int step, SurfaceTiles& tiles) const {
    tiles.require(position(step), kRadius);
    const int x = voxel_index(voxel_key({origin_ + x_at(step), 0, 0})).x();
    return stored_voxels(tiles.voxels(), x - 2, x + 1);
  }

 private:
  Eigen::Vector3d position(int step) const {
    return {static_cast<double>(origin_ + x_at(step)), 0.0, 0.0};
  }

  int origin_;
};

/// Far beyond the indices of voxels, these begin anew.
class SurfaceTilesAt : public testing::TestWithParam<int> {};

TEST_P(SurfaceTilesAt, HoldAMapThatIsMuchLargerThanTheirTable) {
  const TemporaryFolder folder;
  SurfaceTiles few(tiles_of_four_metres(kFewSlots), folder.path());
  SurfaceTiles all(tiles_of_four_metres(kAll), folder.path());
  const Drive drive(GetParam());
  drive.insert_all(few);
  drive.insert_all(all);
  EXPECT_GT(all.size(), 10 * few.voxels().table().capacity());
  EXPECT_EQ(few.size(), all.size());
  EXPECT_EQ(few.bytes(), kFewSlots * sizeof(VoxelSums));
  EXPECT_GT(all.bytes(), 8 * few.bytes());
  for (int i = 0; i < 2 * kSteps; ++i) {
    const int step = 37 * i % kSteps;
    const auto expected = drive.required(step, all);
    ASSERT_GT(expected.size(), 8U);
    ASSERT_EQ(drive.required(step, few), expected) << step;
    ASSERT_EQ(few.bytes(), kFewSlots * sizeof(VoxelSums)) << step;
    ASSERT_EQ(few.size(), all.size()) << step;
  }
  EXPECT_EQ(few.voxels().dropped_points(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Origins, SurfaceTilesAt, testing::Values(0, 2'000'000));

TEST(SurfaceTiles, NeedNoFileWhereTheTableHasRoom) {
  const TemporaryFolder folder;
  const fs::path never = folder.path() / "never", used = folder.path() / "used";
  SurfaceTiles all(tiles_of_four_metres(kAll), never);
  SurfaceTiles few(tiles_of_four_metres(kFewSlots), used);
  Drive(0).insert_all(all);
  Drive(0).insert_all(few);
  EXPECT_FALSE(fs::exists(never));
  ASSERT_TRUE(fs::exists(used));
  EXPECT_TRUE(fs::is_empty(used)) << "the file has no name";
}

// What is required together has to be there together.
TEST(SurfaceTiles, GrowBeyondTheirBoundWhereAnAreaDoesNotFit) {
  const TemporaryFolder folder;
  SurfaceTiles tiles(tiles_of_four_metres(16), folder.path());
  GaussianVoxelMap expected(1.0, 1 << 14);
  for (int step = 0; step < 20; ++step) {
    const Cloud cloud = cloud_around(Drive::x_at(step), static_cast<std::uint32_t>(step));
    tiles.insert({-270.0, 0.0, 0.0}, 35.0, cloud.x.data(), cloud.y.data(), cloud.z.data(), kPoints);
    expected.insert(cloud.x.data(), cloud.y.data(), cloud.z.data(), kPoints);
  }
  EXPECT_GT(expected.size(), 200U);
  EXPECT_EQ(tiles.voxels().size(), expected.size());
  EXPECT_EQ(stored_voxels(tiles.voxels(), -10'000, 10'000),
            stored_voxels(expected, -10'000, 10'000));
  EXPECT_EQ(tiles.voxels().dropped_points(), 0U);
}

TEST(SurfaceTiles, SayWhereTheirFileCannotBeMade) {
  const TemporaryFolder folder;
  const fs::path no_folder = "/dev/null/tiles";
  SurfaceTiles tiles(tiles_of_four_metres(kFewSlots), no_folder);
  const std::string message = error_text<FileError>([&] { Drive(0).insert_all(tiles); });
  EXPECT_NE(message.find("cannot put data aside in /dev/null/tiles: "), std::string::npos)
      << message;
  EXPECT_NE(message.find("; check the free space and the permissions"), std::string::npos)
      << message;
}

/// Exit status 0 if tiles that find no room on the disk once have lost nothing when they find some.
int drive_on_a_full_disk(const fs::path& folder) {
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit full{2048, limit.rlim_max};  // bytes per file: 32 voxels
  ::setrlimit(RLIMIT_FSIZE, &full);
  SurfaceTiles few(tiles_of_four_metres(kFewSlots), folder);
  SurfaceTiles all(tiles_of_four_metres(kAll), folder);
  const Drive drive(0);
  int errors = 0;
  for (int step = 0; step < kSteps; ++step) {
    drive.insert(step, 1, all);
    try {
      drive.insert(step, 1, few);
    } catch (const FileError&) {
      ++errors;
      ::setrlimit(RLIMIT_FSIZE, &limit);
      drive.insert(step, 1, few);
    }
  }
  if (errors != 1 || few.size() != all.size()) return 1;
  for (int step = 0; step < kSteps; ++step) {
    if (drive.required(step, few) != drive.required(step, all)) return 2;
  }
  return 0;
}

TEST(SurfaceTiles, LoseNothingOnAFullDisk) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(drive_on_a_full_disk(folder.path()));
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace lidar_mapping::localization::test
