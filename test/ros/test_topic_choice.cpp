// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/recording_check.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

#include "cloud_builder.hpp"
#include "file_content.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr std::uint8_t kFloat = sensor_msgs::PointField::FLOAT32;

sensor_msgs::PointCloud2 cloud(const std::vector<std::string>& more_fields, std::uint32_t points) {
  std::vector<test::FieldLayout> fields = {{"x", kFloat, 0}, {"y", kFloat, 4}, {"z", kFloat, 8}};
  std::uint32_t offset = 12;
  for (const std::string& name : more_fields) {
    fields.push_back({name, kFloat, offset});
    offset += 4;
  }
  return test::cloud_with(fields, offset, points);
}

class TopicChoice : public testing::Test {
 protected:
  TopicChoice() : bag_(path(), rosbag::bagmode::Write) {}

  std::string path() const { return (folder_.path() / "drive.bag").string(); }
  template <typename Message>
  void record(const std::string& topic, const Message& message, int count) {
    for (int i = 0; i < count; ++i) bag_.write(topic, ros::Time(100 + i), message);
  }
  BagSet recorded() {
    bag_.close();
    return BagSet({path()});
  }

  const test::TemporaryFolder folder_;
  rosbag::Bag bag_;
};

TEST_F(TopicChoice, TakesCloudsForALidarsByTheirFieldsThenByTheirSize) {
  record("/depth/points", cloud({"rgb"}, 5000), 30);
  record("/radar", cloud({"intensity"}, 50), 20);
  record("/registered", cloud({"intensity"}, 900), 10);
  record("/rear/points", cloud({"intensity", "ring"}, 300), 10);
  record("/front/points", cloud({"intensity", "time"}, 1000), 10);
  record("/roof/points", cloud({"intensity", "ring"}, 20000), 10);
  const std::vector<std::string> expected = {"/front/points", "/roof/points", "/rear/points",
                                             "/registered",   "/radar",       "/depth/points"};
  EXPECT_EQ(cloud_topics(recorded()), expected);
  EXPECT_EQ(topics_in(recorded()).points, "/front/points");
}

TEST_F(TopicChoice, PrefersTheTopicsOfTheLaunchFile) {
  record("/front/points", cloud({"intensity", "time"}, 1000), 20);
  record("/kitti/velo/pointcloud", cloud({"intensity"}, 900), 10);
  EXPECT_EQ(topics_in(recorded()).points, "/kitti/velo/pointcloud");
}

TEST_F(TopicChoice, RefusesATopicThatIsNotThere) {
  record("/points", cloud({"intensity"}, 900), 10);
  SensorTopics wanted;
  wanted.points = "/pionts";
  EXPECT_THROW(topics_in(recorded(), wanted), InputError);
  wanted.points = "/points";
  EXPECT_EQ(topics_in(recorded(), wanted).points, "/points");
  wanted.imu = "/points";  // of another type
  EXPECT_THROW(topics_in(recorded(), wanted), InputError);
}

TEST_F(TopicChoice, LeavesOutWhatThisPackagePublishes) {
  record("/mapping/global_map", cloud({"intensity"}, 9000), 5);
  record("/synced_cloud", cloud({"intensity", "time"}, 1000), 10);
  record("/points", cloud({"intensity"}, 1000), 10);
  record("/gnss_datum", sensor_msgs::NavSatFix(), 2);
  record("/fix", sensor_msgs::NavSatFix(), 1);
  EXPECT_EQ(cloud_topics(recorded()), std::vector<std::string>{"/points"});
  EXPECT_EQ(topics_in(recorded()).gnss, "/fix");
}

TEST_F(TopicChoice, NamesTheCloudsThatAreNotUsed) {
  record("/front/points", cloud({"intensity", "ring"}, 1000), 10);
  record("/rear/points", cloud({"intensity", "ring"}, 100), 10);
  RecordingCheck recording;
  const BagSet bags = recorded();
  recording.bags = &bags;
  recording.topics = topics_in(bags);
  EXPECT_NE(check(recording, {}).front().found.find("; other clouds: /rear/points"),
            std::string::npos);
}

// A user is not to be told to map what this package publishes itself.
TEST(OwnOutputs, AreAllThatTheNodesPublishWithTypesOfSensors) {
  const std::regex advertised(
      R"(advertise<(?:sensor_msgs::(?:PointCloud2|Imu|NavSatFix)|nav_msgs::Odometry|geometry_msgs::Twist\w*)>\(\s*"(\w+)\")");
  const std::vector<std::string>& own = own_outputs();
  std::size_t count = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator("../src/nodes")) {
    if (!file.is_regular_file()) continue;
    const std::string text = test::content_of(file.path());
    const std::sregex_iterator end;
    for (std::sregex_iterator found(text.begin(), text.end(), advertised); found != end; ++found) {
      const std::string name = (*found)[1];
      EXPECT_NE(std::find(own.begin(), own.end(), name), own.end()) << name;
      ++count;
    }
  }
  EXPECT_GE(count, 9U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
