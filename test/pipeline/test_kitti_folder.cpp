// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/kitti_folder.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

namespace fs = std::filesystem;

class KittiFolderTest : public testing::Test {
 protected:
  KittiFolderTest() {
    fs::create_directory(folder_.path() / "velodyne");
    fs::create_directory(folder_.path() / "point_times");
  }

  template <typename T>
  void write(const std::string& name, const std::vector<T>& values) const {
    std::ofstream(folder_.path() / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(T)));
  }
  void write_text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }
  std::string path() const { return folder_.path().string(); }

  test::TemporaryFolder folder_;
};

TEST_F(KittiFolderTest, ReadsScansInTheOrderOfTheirNames) {
  write<float>("velodyne/000001.bin", {5, 6, 7, 0.5F});
  write<float>("velodyne/000000.bin", {1, 2, 3, 0.25F, 4, 5, 6, 0});
  write_text("times.txt", "10.5\n10.75\n");
  const KittiFolder folder(path());
  ASSERT_EQ(folder.size(), 2U);
  EXPECT_EQ(folder.scan(0).cloud.size(), 2U);
  EXPECT_EQ(folder.scan(0).cloud.points[0].intensity, 0.25F);
  EXPECT_EQ(folder.scan(1).cloud.points[0].x, 5.0F);
  EXPECT_EQ(folder.scan(1).stamp, 10750000000);
  EXPECT_FALSE(folder.scan(0).cloud.has_times());
}

TEST_F(KittiFolderTest, UsesTenHertzWithoutTimes) {
  write<float>("velodyne/000000.bin", {1, 2, 3, 0});
  write<float>("velodyne/000001.bin", {1, 2, 3, 0});
  EXPECT_EQ(KittiFolder(path()).stamp(1), 100000000);
}

TEST_F(KittiFolderTest, ReadsTimesOfPoints) {
  write<float>("velodyne/000000.bin", {1, 2, 3, 0, 4, 5, 6, 0});
  write<float>("point_times/000000.f32", {-0.05F, 0.05F});
  EXPECT_EQ(KittiFolder(path()).scan(0).cloud.times, (std::vector<float>{-0.05F, 0.05F}));
}

TEST_F(KittiFolderTest, ComputesTimesFromAzimuth) {
  write<float>("velodyne/000000.bin", {1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0});
  const Scan scan = KittiFolder(path(), {0.0, true}).scan(0);
  EXPECT_NEAR(scan.cloud.times[0], 0.0, 1e-7);
  EXPECT_NEAR(scan.cloud.times[1], -0.026, 1e-6);  // the left is seen earlier
  EXPECT_NEAR(scan.cloud.times[2], 0.026, 1e-6);
}

TEST_F(KittiFolderTest, RejectsInconsistentFiles) {
  EXPECT_THROW(KittiFolder{path()}, FileError);
  EXPECT_THROW(KittiFolder{path() + "/nowhere"}, FileError);
  write<float>("velodyne/000000.bin", {1, 2, 3});
  EXPECT_THROW(KittiFolder(path()).scan(0), FileError);
  write<float>("velodyne/000000.bin", {1, 2, 3, 0});
  write<float>("point_times/000000.f32", {0, 0});
  EXPECT_THROW(KittiFolder(path()).scan(0), FileError);
  write_text("times.txt", "");
  EXPECT_THROW(KittiFolder{path()}, FileError);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
