// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/folder_input.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

namespace fs = std::filesystem;

class FolderInputTest : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
  }
  void write_bin(const std::string& name, const std::vector<float>& values) const {
    write(name,
          std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
  }
  /// A raw recording of two scans, between which one is missing, and two samples of oxts.
  void write_raw() const {
    write("velodyne_points/timestamps.txt",
          "2011-09-26 13:02:25.500000000\n2011-09-26 13:02:25.6\n2011-09-26 13:02:25.700000001\n");
    write("velodyne_points/data/0000000000.txt", "1 2 3 0.5\n4 5 6 0.25\n");
    write_bin("velodyne_points/data/0000000002.bin", {7, 8, 9, 1});
    write("oxts/timestamps.txt", "2011-09-26 13:02:25.51\n2011-09-26 13:02:25.61\n");
    const std::string line =
        "49.0 8.4 110.5 0.01 0.02 1.5 0 0 10.0 0.1 0.2 0.3 0.4 9.8 0 0 0 0.5 0.6 0.7 0 0 0 0.03 "
        "0.02 4 9 4 4 0\n";
    write("oxts/data/0000000000.txt", line);
    write("oxts/data/0000000001.txt", line);
    write("calib_imu_to_velo.txt", "calib_time: x\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
  }
  FolderInput open() const { return FolderInput(folder_.path().string()); }

  static std::vector<Input> all(FolderInput& input) {
    std::vector<Input> inputs;
    while (auto datum = input.next()) inputs.push_back(std::move(*datum));
    return inputs;
  }

  test::TemporaryFolder folder_;
};

constexpr Stamp kDate = 1317042145'500000000;  // 2011-09-26 13:02:25.5 UTC

TEST_F(FolderInputTest, ReadsKittiRawRecording) {
  write_raw();
  FolderInput input = open();
  const std::vector<Input> inputs = all(input);
  ASSERT_EQ(inputs.size(), 8U);
  const auto& imu = std::get<FramedSample<ImuSample>>(inputs[0]);
  EXPECT_EQ(imu.sample.stamp, kDate + 10000000);
  EXPECT_EQ(imu.sample.angular_velocity, Eigen::Vector3d(0.5, 0.6, 0.7));
  EXPECT_EQ(imu.sample.linear_acceleration, Eigen::Vector3d(0.3, 0.4, 9.8));
  EXPECT_NEAR(yaw_of(*imu.sample.orientation), 1.5, 1e-9);
  const auto& velocity = std::get<FramedSample<VelocitySample>>(inputs[1]);
  EXPECT_EQ(velocity.sample.linear, Eigen::Vector3d(10.0, 0.1, 0.2));
  const auto& fix = std::get<FramedSample<GnssFix>>(inputs[2]);
  EXPECT_EQ(fix.sample.altitude_m, 110.5);
  EXPECT_NEAR((*fix.sample.covariance)(0, 0), 0.0009, 1e-12);
  const auto& first = std::get<RecordedScan>(inputs[3]);
  EXPECT_EQ(first.stamp, kDate);
  EXPECT_EQ(first.decode({}).cloud.size(), 2U);
  const auto& last = std::get<RecordedScan>(inputs[7]);
  EXPECT_EQ(last.stamp, kDate + 200000001);
  EXPECT_EQ(last.decode({}).cloud.points[0].x, 7.0F);
  const auto T_base_imu = input.T_base(imu.frame_id);
  ASSERT_TRUE(T_base_imu);
  EXPECT_TRUE(test::near(T_base_imu->translation, Eigen::Vector3d(-0.8, 0.3, 1.73 - 0.8), 1e-9));
}

TEST_F(FolderInputTest, LeavesOutImuWithUnknownPose) {
  write_raw();
  fs::remove(folder_.path() / "calib_imu_to_velo.txt");
  FolderInput input = open();
  EXPECT_EQ(all(input).size(), 2U);
  EXPECT_NE(input.description().find("calib_imu_to_velo.txt"), std::string::npos);
}

TEST_F(FolderInputTest, RejectsInvalidPoseOfImu) {
  for (const char* translation : {"1e300 0 0", "0 0 nan", "0 0", "0 0.1x 0"}) {
    write_raw();
    write("calib_imu_to_velo.txt", std::string("R: 1 0 0 0 1 0 0 0 1\nT: ") + translation + "\n");
    EXPECT_THROW(open(), FileError) << translation;
  }
}

TEST_F(FolderInputTest, ReportsLineOfInvalidDate) {
  write_raw();
  write("oxts/timestamps.txt", "2011-09-26 13:02:25.51\nyesterday\n");
  const std::string text = test::error_text<FileError>([&] { open(); });
  EXPECT_NE(text.find("line 2: 'yesterday'"), std::string::npos) << text;
}

TEST_F(FolderInputTest, CountsEmptyLinesBeforeAnInvalidDate) {
  write_raw();
  write("oxts/timestamps.txt", "2011-09-26 13:02:25.51\n\n\nyesterday\n");
  const std::string text = test::error_text<FileError>([&] { open(); });
  EXPECT_NE(text.find("line 4: 'yesterday'"), std::string::npos) << text;
}

TEST_F(FolderInputTest, ReadsPcdFilesWithTimesInTheirNames) {
  session::write_pcd(folder_.path() / "1317617735.500.pcd", {{{1, 2, 3, 4}}, {}});
  session::write_pcd(folder_.path() / "1317617735.250.pcd", {{{5, 6, 7, 8}}, {}});
  FolderInput input = open();
  const std::vector<Input> inputs = all(input);
  ASSERT_EQ(inputs.size(), 2U);
  const auto& scan = std::get<RecordedScan>(inputs[0]);
  EXPECT_EQ(scan.stamp, 1317617735'250000000);
  EXPECT_EQ(scan.decode({}).cloud.points[0].x, 5.0F);
}

TEST_F(FolderInputTest, UsesTenHertzForNumberedScans) {
  write_bin("000000.bin", {1, 2, 3, 4});
  write_bin("000001.bin", {1, 2, 3, 4});
  FolderInput input = open();
  input.skip_to(input.end());
  const std::vector<Input> inputs = all(input);
  ASSERT_EQ(inputs.size(), 1U);
  EXPECT_EQ(std::get<RecordedScan>(inputs[0]).stamp, 100000000);
}

// By their letters, 10 comes before 2.
TEST_F(FolderInputTest, ReadsNumberedScansInTheOrderOfTheirNumbers) {
  for (int i = 0; i < 12; ++i) {
    write_bin(std::to_string(i) + ".bin", {1.0F, 2.0F, 3.0F, static_cast<float>(i)});
  }
  FolderInput input = open();
  const std::vector<Input> inputs = all(input);
  ASSERT_EQ(inputs.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    const auto& scan = std::get<RecordedScan>(inputs[i]);
    EXPECT_EQ(scan.stamp, from_seconds(0.1 * static_cast<double>(i)));
    EXPECT_EQ(scan.decode({}).cloud.points[0].intensity, static_cast<float>(i));
  }
}

TEST_F(FolderInputTest, NamesAFolderThatIsMissing) {
  const auto said = [&] { return test::error_text<FileError>([&] { open(); }); };
  write_raw();
  fs::remove_all(folder_.path() / "oxts/data");
  EXPECT_NE(said().find("no folder"), std::string::npos);
  EXPECT_NE(said().find("oxts/data"), std::string::npos);
  fs::remove_all(folder_.path() / "velodyne_points/data");
  EXPECT_NE(said().find("velodyne_points/data"), std::string::npos);
}

TEST_F(FolderInputTest, RejectsFolderWithoutScans) { EXPECT_THROW(open(), FileError); }

}  // namespace
}  // namespace lidar_mapping::pipeline
