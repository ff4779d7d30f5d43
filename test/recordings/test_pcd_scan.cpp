// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "pcd_scan.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::recordings {
namespace {

class PcdScanTest : public testing::Test {
 protected:
  /// Three points with these further fields, given as PCD's header and lines want them.
  std::string file_with(const std::string& fields, const std::string& sizes,
                        const std::string& types, const std::vector<std::string>& values) const {
    const std::string path = (folder_.path() / "scan.pcd").string();
    std::ofstream file(path);
    file << "VERSION 0.7\nFIELDS x y z" << fields << "\nSIZE 4 4 4" << sizes << "\nTYPE F F F"
         << types << "\nCOUNT 1 1 1";
    for (std::size_t i = 0; i < sizes.size() / 2; ++i) file << " 1";
    file << "\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n";
    for (const std::string& value : values) file << "1 2 3" << value << '\n';
    return path;
  }

  test::TemporaryFolder folder_;
};

TEST_F(PcdScanTest, TakesTimesAndIntensitiesUnderTheNamesOfDrivers) {
  const auto scan = read_pcd_scan(
      file_with(" reflectivity t", " 2 4", " U U", {" 7 0", " 8 50000000", " 9 99900000"}), 5, {});
  EXPECT_EQ(scan.stamp, 5);
  ASSERT_EQ(scan.cloud.times.size(), 3U);
  EXPECT_NEAR(scan.cloud.times[1], 0.05F, 1e-6);
  EXPECT_EQ(scan.cloud.points[1].intensity, 8.0F);
  EXPECT_EQ(scan.cloud.points[1].z, 3.0F);
}

TEST_F(PcdScanTest, ReadsPlainScans) {
  const auto scan = read_pcd_scan(file_with(" intensity", " 4", " F", {" 1", " 2", " 3"}), 5, {});
  EXPECT_EQ(scan.stamp, 5);
  EXPECT_FALSE(scan.cloud.has_times());
  ASSERT_EQ(scan.cloud.size(), 3U);
  EXPECT_EQ(scan.cloud.points[2].intensity, 3.0F);
}

TEST_F(PcdScanTest, RefusesWhatWasCutOff) {
  const std::string path = file_with(" t", " 4", " F", {" 0", " 0.05", " 0.1"});
  std::filesystem::resize_file(path, 60);
  EXPECT_THROW(read_pcd_scan(path, 5, {}), FileError);
}

}  // namespace
}  // namespace lidar_mapping::recordings
