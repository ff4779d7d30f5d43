// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "bag_input.hpp"
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
  BagInput input({path}, {}, "base_link", {});
  std::size_t count = 0;
  while (input.next()) ++count;
  EXPECT_EQ(count, 3U);
}

}  // namespace
}  // namespace lidar_mapping::recordings
