// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/silent_topic.hpp"

namespace lidar_mapping::ros_border {
namespace {

const std::string kType = "sensor_msgs/Imu";

std::string why(const ros::master::V_TopicInfo& published) {
  return why_silent("/imu", {kType}, published, {"/synced_imu"}, "imu");
}

TEST(WhySilent, NamesTopicsOfTheSameTypeButNotOurOwn) {
  EXPECT_EQ(why({{"/synced_imu", kType},
                 {"/scan", "sensor_msgs/LaserScan"},
                 {"/a", kType},
                 {"/b", kType}}),
            "nobody publishes /imu; topics of sensor_msgs/Imu that are published: /a, /b (choose "
            "one with imu:=TOPIC)");
}

TEST(WhySilent, SaysThatThereIsNone) {
  EXPECT_EQ(why({{"/synced_imu", kType}}),
            "nobody publishes /imu, nor another topic of sensor_msgs/Imu: play a bag or start the "
            "driver");
}

TEST(WhySilent, DistinguishesASilentPublisherFromOneOfAnotherType) {
  EXPECT_EQ(why({{"/a", kType}, {"/imu", kType}}),
            "no message has arrived on /imu yet, although it is published");
  EXPECT_EQ(why({{"/imu", "std_msgs/String"}}),
            "/imu is published as std_msgs/String, not as sensor_msgs/Imu");
}

TEST(WhySilent, TakesEachOfTheTypes) {
  const std::vector<std::string> types = {"a/A", "b/B"};
  EXPECT_EQ(why_silent("/points", types, {{"/other", "b/B"}, {"/third", "c/C"}}, {}, "points"),
            "nobody publishes /points; topics of b/B that are published: /other (choose one with "
            "points:=TOPIC)");
  EXPECT_EQ(why_silent("/points", types, {{"/points", "b/B"}}, {}, "points"),
            "no message has arrived on /points yet, although it is published");
}

}  // namespace
}  // namespace lidar_mapping::ros_border
