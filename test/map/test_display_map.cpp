// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/map/display_map.hpp"

namespace lidar_mapping::map {
namespace {

/// A road along x: each key frame sees the square of 2 m around it as 40 by 40 points.
class Road : public CloudSource {
 public:
  PointCloudPtr cloud(KeyFrameIndex /*index*/) override {
    ++read;
    auto cloud = std::make_shared<PointCloud>();
    for (int i = 0; i < 1600; ++i) {
      Point point;
      point.x = 0.05F * static_cast<float>(i % 40) - 0.975F;
      point.y = 0.05F * static_cast<float>(i / 40) - 0.975F;
      cloud->points.push_back(point);
    }
    return cloud;
  }
  std::size_t read = 0;
};

KeyFramePoses along_the_road(KeyFrameIndex count) {
  KeyFramePoses poses;
  for (KeyFrameIndex i = 0; i < count; ++i) {
    Pose pose;
    pose.translation.x() = 2.0 * i;
    poses.poses.push_back({i, Stamp{i}, pose});
  }
  return poses;
}

MapConfig on_one_thread() {
  MapConfig config;
  config.threads = 1;  // Road counts
  return config;
}

void expect_map(const PointCloud& cloud, KeyFrameIndex key_frames, double resolution) {
  MapConfig config = on_one_thread();
  config.resolution = resolution;
  Road road;
  const PointCloud expected = build_map(along_the_road(key_frames), road, config);
  ASSERT_EQ(cloud.size(), expected.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_EQ(cloud.points[i].position(), expected.points[i].position()) << i;
  }
}

TEST(DisplayMap, HasTheConfiguredVoxelsAsLongAsTheirPointsAreFewEnough) {
  Road road;
  DisplayMap display(on_one_thread(), road, 3000);
  EXPECT_TRUE(display.update(along_the_road(20)));
  expect_map(display.build(), 20, 0.2);
  EXPECT_EQ(display.resolution(), 0.2);
  EXPECT_EQ(road.read, 20U);
  EXPECT_FALSE(display.update(along_the_road(20))) << "nothing is new";
  EXPECT_TRUE(display.update(along_the_road(21)));
  display.build();
  EXPECT_EQ(road.read, 21U) << "only the new cloud is read";
}

TEST(DisplayMap, HasLargerVoxelsTheLongerTheDrive) {
  Road road;
  DisplayMap display(on_one_thread(), road, 3000);
  display.update(along_the_road(20));
  display.build();
  display.update(along_the_road(60));
  expect_map(display.build(), 60, 0.4);
  EXPECT_EQ(display.resolution(), 0.4);
  display.update(along_the_road(240));
  const PointCloud cloud = display.build();
  expect_map(cloud, 240, 0.8);
  EXPECT_LE(cloud.size(), 3000U);
}

/// A resumed drive comes at once; it is counted before it is in memory.
TEST(DisplayMap, ReadsOnlyAPartOfALongDriveWithVoxelsThatAreTooSmall) {
  constexpr KeyFrameIndex kMany = 5000;
  Road road;
  DisplayMap display(on_one_thread(), road, 55'000);
  display.update(along_the_road(kMany));
  const PointCloud cloud = display.build();
  EXPECT_LE(cloud.size(), 55'000U);
  EXPECT_EQ(display.resolution(), 0.8);
  EXPECT_LT(road.read, 2U * kMany);
}

TEST(DisplayMap, KeepsTheLargestVoxelsIfEvenTheirPointsAreTooMany) {
  Road road;
  DisplayMap display(on_one_thread(), road, 1);
  display.update(along_the_road(100));
  EXPECT_GT(display.build().size(), 1U);
  EXPECT_EQ(display.resolution(), 6.4);
  EXPECT_EQ(display.missing_clouds(), 0U);
}

TEST(DisplayResolution, BecomesCoarserWithTheMap) {
  EXPECT_EQ(display_resolution(0), 0.5);
  EXPECT_EQ(display_resolution(100'000), 0.5) << "a town";
  EXPECT_EQ(display_resolution(1'600'000), 1.0) << "sixteen towns";
  EXPECT_EQ(display_resolution(20'000'000), 4.0) << "200 km";
}

TEST(DisplayMap, LosesTheKeyFramesThatAreGone) {
  Road road;
  DisplayMap display(on_one_thread(), road);
  display.update(along_the_road(20));
  display.build();
  EXPECT_TRUE(display.update(along_the_road(10)));
  expect_map(display.build(), 10, 0.2);
}

}  // namespace
}  // namespace lidar_mapping::map
