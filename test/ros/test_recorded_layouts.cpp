// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include "cloud_builder.hpp"
#include "test_data.hpp"

namespace lidar_mapping::ros_border {
namespace {

/// Times of a recorded scan span about its period and refer to its stamp.
void expect_recorded(const std::filesystem::path& file, const ros::Time& stamp,
                     const std::string& unit, bool absolute) {
  const DecodedCloud decoded = decode(test::read_pcd(file, stamp), {});
  const auto& times = decoded.scan.cloud.times;
  ASSERT_EQ(times.size(), decoded.scan.cloud.size());
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  EXPECT_NEAR(*last - *first, 0.1, 0.005);
  EXPECT_LT(std::abs(*first), 0.11);
  EXPECT_EQ(decoded.format.time_unit, unit);
  EXPECT_EQ(decoded.scan.times_are_absolute, absolute);
  EXPECT_FALSE(decoded.format.foreign_clock);
}

TEST(RecordedLayouts, ReadsRecordedVelodyne) {
  REQUIRE_RECORDED(folder, "velodyne_vlp16");
  expect_recorded(folder / "000000.pcd", ros::Time(1600000000, 5), "s", false);
}

TEST(RecordedLayouts, ReadsRecordedOuster) {
  REQUIRE_RECORDED(folder, "ouster_os1_128");
  expect_recorded(folder / "000000.pcd", ros::Time(1600000000, 5), "ns", false);
}

TEST(RecordedLayouts, ReadsRecordedHesai) {
  REQUIRE_RECORDED(folder, "hesai_xt32");
  expect_recorded(folder / "000000.pcd", ros::Time(1673400677, 700635000), "s", true);
}

TEST(RecordedLayouts, ReadsRecordedRoboSense) {
  REQUIRE_RECORDED(folder, "robosense_32");
  expect_recorded(folder / "000000.pcd", ros::Time(1600000000, 5), "ns", false);
}

TEST(RecordedLayouts, ReadsRecordedRingsWithoutTimes) {
  REQUIRE_RECORDED(folder, "ring32");
  const DecodedCloud decoded = decode(test::read_pcd(folder / "000000.pcd", ros::Time(5, 0)), {});
  EXPECT_GT(decoded.scan.cloud.size(), 10000U);
  EXPECT_FALSE(decoded.scan.cloud.has_times());
}

}  // namespace
}  // namespace lidar_mapping::ros_border
