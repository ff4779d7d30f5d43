// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cloud_forms.hpp"
#include "near.hpp"
#include "other_lidars.hpp"

namespace lidar_mapping::recordings {
namespace {

using Milliseconds = std::vector<Stamp>;
using Missed = std::map<std::string, std::size_t>;

constexpr Stamp kMillisecond = 1'000'000;  // ns

class OtherLidarsTest : public testing::Test {
 protected:
  OtherLidarsTest() {
    others_.add_lidar("/left", Pose{Eigen::Quaterniond::Identity(), {0.0, 1.0, 0.0}});
    others_.add_lidar("/right", Pose{Eigen::Quaterniond::Identity(), {0.0, -1.0, 0.0}});
  }
  void add(const std::string& topic, const Milliseconds& times) {
    for (const Stamp time : times) others_.add(topic, {}, time * kMillisecond);
  }
  Milliseconds around(Stamp time) {
    Milliseconds result;
    for (const auto& cloud : others_.around(time * kMillisecond)) {
      result.push_back(cloud->stamp() / kMillisecond);
    }
    return result;
  }

  OtherLidars others_{0.1};
};

TEST_F(OtherLidarsTest, KnowsTheLidarsThatWereAdded) {
  EXPECT_TRUE(OtherLidars(0.1).empty());
  EXPECT_FALSE(others_.empty());
  EXPECT_TRUE(others_.has("/left"));
  EXPECT_FALSE(others_.has("/behind"));
  add("/right", {5});
  EXPECT_TRUE(test::near(others_.around(0).front()->T_main_other().translation,
                         Eigen::Vector3d(0.0, -1.0, 0.0), 1e-12));
}

TEST_F(OtherLidarsTest, GivesTheCloudsWithinReach) {
  add("/left", {899, 900, 950, 1000, 1100, 1101});
  EXPECT_EQ(around(1000), Milliseconds({900, 950, 1000, 1100}));
  EXPECT_EQ(around(1050), Milliseconds({950, 1000, 1100, 1101})) << "a cloud may serve twice";
}

TEST_F(OtherLidarsTest, GivesThoseOfAllLidars) {
  add("/right", {1010, 1110});
  add("/left", {990, 1090});
  EXPECT_EQ(around(1000), Milliseconds({990, 1090, 1010}));
}

TEST_F(OtherLidarsTest, TakesStampsInAnyOrderWithinReach) {
  add("/left", {1000, 1300, 990});
  EXPECT_EQ(around(1000), Milliseconds({1000, 990}));
}

TEST_F(OtherLidarsTest, DiscardsCloudsBeforeTheScan) {
  add("/left", {1000, 1200});
  EXPECT_EQ(around(1150), Milliseconds({1200}));
  EXPECT_EQ(around(1000), Milliseconds()) << "scans come in their order";
}

TEST_F(OtherLidarsTest, CountsTheScansWithoutACloud) {
  add("/left", {1000, 1500});
  around(1000);
  EXPECT_EQ(others_.missed(), (Missed{{"/right", 1}}));
  around(1250);
  around(1500);
  EXPECT_EQ(others_.missed(), (Missed{{"/left", 1}, {"/right", 3}}));
}

/// A cloud of a hundred points along x, whose data lie in `data`.
ros_border::RecordedCloud recorded(sensor_msgs::PointCloud2& data) {
  std_msgs::Header header;
  header.stamp = ros::Time(7);
  header.frame_id = "left";
  std::vector<test::TimedPoint> points;
  for (int i = 0; i < 100; ++i) {
    const auto f = static_cast<float>(i);
    points.push_back({f, 2.0F, -1.0F, 5.0F, 0.001F * f});
  }
  data = test::plain_cloud(header, points);
  ros_border::RecordedCloud cloud;
  cloud.message = data;
  cloud.message.data.clear();
  cloud.data = {data.data.data(), data.data.size()};
  return cloud;
}

TEST(OtherCloud, IsDecodedOnceWithTheStampThatItWasGiven) {
  const preprocessing::PreprocessingConfig config;
  const ros_border::CloudReader reader(config);
  sensor_msgs::PointCloud2 data;
  ros_border::RecordedCloud whole = recorded(data);
  auto memory = std::make_shared<int>(0);
  const std::weak_ptr<int> is_held = memory;
  whole.memory = std::move(memory);
  OtherCloud cloud(std::move(whole), 42, Pose());
  EXPECT_FALSE(is_held.expired());
  const preprocessing::RawScan& scan = cloud.decoded(reader);
  EXPECT_TRUE(is_held.expired()) << "its memory is free again";
  EXPECT_EQ(scan.stamp, 42);
  ASSERT_EQ(scan.cloud.size(), 100U);
  EXPECT_EQ(scan.cloud.points[7].position(), Eigen::Vector3f(7.0F, 2.0F, -1.0F));
  EXPECT_EQ(&cloud.decoded(reader), &scan);
  EXPECT_EQ(scan.cloud.size(), 100U);
}

TEST(OtherCloud, HasNoPointsIfTheyCannotBeRead) {
  const preprocessing::PreprocessingConfig config;
  sensor_msgs::PointCloud2 data;
  ros_border::RecordedCloud cut = recorded(data);
  cut.data.size -= 1;
  OtherCloud cloud(std::move(cut), 42, Pose());
  const preprocessing::RawScan& scan = cloud.decoded(ros_border::CloudReader(config));
  EXPECT_TRUE(scan.cloud.empty());
  EXPECT_EQ(scan.stamp, 42);
}

}  // namespace
}  // namespace lidar_mapping::recordings
