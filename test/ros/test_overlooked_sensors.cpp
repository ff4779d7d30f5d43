// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/overlooked_sensors.hpp"

namespace lidar_mapping::ros_border {
namespace {

OverlookedSensors sensors() {
  return {{{"imu", "/imu", {"sensor_msgs/Imu"}},
           {"gnss", "/fix", {"sensor_msgs/NavSatFix", "geographic_msgs/GeoPointStamped"}}},
          {"/synced_imu", "/gnss_datum"}};
}

TEST(OverlookedSensors, NamesTopicsThatCouldBeMeantOnce) {
  OverlookedSensors overlooked = sensors();
  const ros::master::V_TopicInfo published = {{"/imu/data", "sensor_msgs/Imu"},
                                              {"/map_datum", "geographic_msgs/GeoPointStamped"},
                                              {"/scan", "sensor_msgs/LaserScan"},
                                              {"/synced_imu", "sensor_msgs/Imu"}};
  const auto lines = overlooked.search(published);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines.at("imu"),
            "nobody publishes /imu, so the map is made without; published and not used: /imu/data "
            "(sensor_msgs/Imu) (choose one with imu:=TOPIC)");
  EXPECT_NE(lines.at("gnss").find("/map_datum (geographic_msgs/GeoPointStamped)"),
            std::string::npos);
  EXPECT_TRUE(overlooked.search(published).empty()) << "said once";
  EXPECT_TRUE(overlooked.is_complete());
}

TEST(OverlookedSensors, GivesNoFalseAlarm) {
  OverlookedSensors overlooked = sensors();
  EXPECT_TRUE(overlooked
                  .search({{"/synced_imu", "sensor_msgs/Imu"},
                           {"/gnss_datum", "sensor_msgs/NavSatFix"},
                           {"/points", "sensor_msgs/PointCloud2"}})
                  .empty())
      << "a LiDAR alone, and what this package publishes itself";
  EXPECT_TRUE(
      overlooked.search({{"/imu", "sensor_msgs/Imu"}, {"/imu_2", "sensor_msgs/Imu"}}).empty())
      << "the first fix of a drive may be long in coming";
  EXPECT_FALSE(overlooked.is_complete());
  overlooked.mark_received("imu");
  EXPECT_TRUE(overlooked.search({{"/imu_2", "sensor_msgs/Imu"}}).empty()) << "it is there";
}

}  // namespace
}  // namespace lidar_mapping::ros_border
