// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "bag_input.hpp"
#include "ouster_packet_message.hpp"
#include "ouster_turn.hpp"
#include "ros2_writer.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::recordings {
namespace {

/// A database may hold any number as a time; one that ROS cannot hold ended the reading.
TEST(BagInput, ReadsOnBehindATimeOfRecordingThatIsNone) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "drive.db3").string();
  {
    test::Ros2Writer out(path);
    sensor_msgs::Imu imu;
    imu.header.stamp = ros::Time(100);
    for (int i = 0; i < 3; ++i) out.add("/imu", ros::Time(100 + i), imu);
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  const char* const change = "UPDATE messages SET timestamp = -1 WHERE id = 1";
  EXPECT_EQ(sqlite3_exec(database, change, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  const auto input = make_bag_input({path}, {}, "base_link", {});
  std::size_t count = 0;
  while (input->next()) ++count;
  EXPECT_EQ(count, 3U);
}

// A LiDAR counts by TAI (37 s ahead of UTC), or from its start. Parts of a recording are chosen by
// the stamps of its scans.
TEST(BagInput, CountsByTheClockOfTheStamps) {
  constexpr Stamp kRecorded = 1'700'000'000'000'000'000;
  for (const double ahead : {37.0, -37.0, -1.6e9, -0.05}) {
    const test::TemporaryFolder folder;
    const std::string path = (folder.path() / "drive.bag").string();
    const Stamp first = kRecorded + from_seconds(ahead);
    {
      rosbag::Bag bag(path, rosbag::bagmode::Write);
      for (int i = 0; i < 20; ++i) {
        const Stamp since = from_seconds(0.1 * i);
        bag.write("/points", ros_border::to_ros(kRecorded + since),
                  ros_border::to_message({{{1.0F, 2.0F, 3.0F, 4.0F}}, {}}, first + since, "lidar"));
      }
    }
    const auto input = make_bag_input({path}, {}, "base_link", {});
    EXPECT_LT(std::abs(to_seconds(input->begin() - first)), 0.1) << ahead;
    EXPECT_NEAR(to_seconds(input->end() - input->begin()), 1.9, 1e-6) << ahead;
    input->skip_to(input->begin() + from_seconds(0.95));
    std::vector<Stamp> stamps;
    while (const auto datum = input->next()) {
      stamps.push_back(std::get<pipeline::RecordedScan>(*datum).stamp);
    }
    ASSERT_EQ(stamps.size(), 10U) << ahead;
    EXPECT_EQ(stamps.front(), first + from_seconds(1.0)) << ahead;
  }
}

/// Records packets of two turns of an Ouster, and the last one of the first turn once more behind
/// the first one of the second.
void record_a_late_packet(const std::string& path) {
  constexpr Stamp kBegin = 1'700'000'000'000'000'000;  // ns
  const test::OusterSensor sensor = test::small_ouster();
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  std_msgs::String metadata;
  metadata.data = sensor.metadata();
  bag.write("/os/metadata", ros_border::to_ros(kBegin), metadata);
  Stamp recorded = kBegin;
  const auto record = [&](std::uint16_t turn, std::size_t index) {
    test::OusterPacketMessage message;
    message.buf = test::packet_of_turn(
        sensor, turn, index, static_cast<std::uint64_t>(kBegin) + turn * test::kOusterTurn);
    recorded += from_seconds(0.025);
    bag.write("/os/lidar_packets", ros_border::to_ros(recorded), message);
  };
  for (std::size_t index = 0; index < 4; ++index) record(0, index);
  record(1, 0);
  record(0, 3);
  for (std::size_t index = 1; index < 4; ++index) record(1, index);
}

TEST(BagInput, SaysHowManyPacketsCameLate) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "drive.bag").string();
  record_a_late_packet(path);
  const auto input = make_bag_input({path}, {}, "base_link", {});
  std::size_t scans = 0;
  while (input->next()) ++scans;
  EXPECT_EQ(scans, 2U);
  EXPECT_EQ(input->take_messages(),
            std::vector<std::string>{
                "packets of the sensor that came behind their turn and were left out: 1"});
}

}  // namespace
}  // namespace lidar_mapping::recordings
