// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/free_space_image.hpp"

#include "made_map.hpp"
#include "near.hpp"
#include "visible_cloud.hpp"

namespace lidar_mapping::map_import {
namespace {

using test::MadeMap;
using test::near;

const Eigen::Vector3d kLidar(0.0, 0.0, 1.8);

PointCloud seen(const MadeMap& map, const Pose& T_map_base = {}) {
  return visible_cloud({map.tile()}, T_map_base, kLidar, MadeMap::kStep);
}

template <typename Holds>
std::ptrdiff_t count(const PointCloud& cloud, const Holds& holds) {
  return std::count_if(cloud.points.begin(), cloud.points.end(), holds);
}

MadeMap two_walls() {
  MadeMap map;
  map.add_rectangle({10.0, -10.0, 0.0}, {0.0, 20.0, 0.0}, {0.0, 0.0, 6.0});
  map.add_rectangle({14.0, -5.0, 0.0}, {0.0, 10.0, 0.0}, {0.0, 0.0, 4.0});
  return map;
}

TEST(VisibleCloud, HasNothingBehindAWall) {
  const PointCloud cloud = seen(two_walls());
  EXPECT_GT(count(cloud, [](const Point& p) { return std::abs(p.x - 10.0F) < 1e-3F; }), 1000);
  EXPECT_EQ(count(cloud, [](const Point& p) { return p.x > 10.1F; }), 0);
}

TEST(VisibleCloud, HasTheWallThatIsSeenAboveALowerOne) {
  MadeMap map;
  map.add_rectangle({10.0, -10.0, 0.0}, {0.0, 20.0, 0.0}, {0.0, 0.0, 3.0});
  map.add_rectangle({20.0, -5.0, 0.0}, {0.0, 10.0, 0.0}, {0.0, 0.0, 8.0});
  const PointCloud cloud = seen(map);
  const auto is_far = [](const Point& p) { return p.x > 19.0F; };
  EXPECT_GT(count(cloud, is_far), 200);
  // The ray above the lower wall is at 4.2 m there.
  EXPECT_EQ(count(cloud, [&](const Point& p) { return is_far(p) && p.z < 3.9F; }), 0);
}

TEST(VisibleCloud, HasTheGroundFarAway) {
  MadeMap map;
  map.add_rectangle({-90.0, -4.0, 0.0}, {180.0, 0.0, 0.0}, {0.0, 8.0, 0.0});
  const PointCloud cloud = seen(map);
  EXPECT_GT(count(cloud, [](const Point& p) { return p.x > 60.0F; }), 5);
  EXPECT_GT(count(cloud, [](const Point& p) { return std::abs(p.x) < 10.0F; }), 1000);
  for (const Point& p : cloud.points) {
    EXPECT_NEAR(p.z, 0.0F, 1e-4F);
    EXPECT_LT((p.position() - kLidar.cast<float>()).norm(), kSight);
  }
}

TEST(VisibleCloud, HasNoUpperSideOfACeiling) {
  MadeMap map;
  for (const double height : {0.0, 2.5, 2.8}) {
    map.add_rectangle({-10.0, -10.0, height}, {20.0, 0.0, 0.0}, {0.0, 20.0, 0.0});
  }
  const PointCloud cloud = seen(map);
  EXPECT_GT(count(cloud, [](const Point& p) { return std::abs(p.z - 2.5F) < 0.01F; }), 1000);
  EXPECT_EQ(count(cloud, [](const Point& p) { return p.z > 2.65F; }), 0);
}

TEST(VisibleCloud, IsInBaseLink) {
  const Pose T_map_base{exp_so3({0.0, 0.0, 2.0}), {3.0, -4.0, 5.0}};
  MadeMap map = two_walls();
  const PointCloud expected = seen(map);
  for (MapPoint& point : map.points) point.p_map = T_map_base * point.p_map;
  const PointCloud cloud = seen(map, T_map_base);
  EXPECT_NEAR(static_cast<double>(cloud.size()), static_cast<double>(expected.size()),
              0.05 * static_cast<double>(expected.size()));
  for (const Point& p : cloud.points) EXPECT_NEAR(p.x, 10.0F, 1e-3F);
}

TEST(VisibleCloud, LeavesOutWhatIsTooNearOrTooSteep) {
  MadeMap map;
  map.points.push_back({{0.1, 0.0, 1.8}, 1.0F});   // what the map has of its own vehicle
  map.points.push_back({{0.0, 0.0, 0.0}, 1.0F});   // below the LiDAR
  map.points.push_back({{0.0, 81.0, 1.8}, 1.0F});  // beyond the range of sight
  map.points.push_back({{5.0, 0.0, 1.8}, 7.0F});
  const PointCloud cloud = seen(map);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_TRUE(near(cloud.points.front().position(), Eigen::Vector3f(5.0F, 0.0F, 1.8F), 1e-5));
  EXPECT_EQ(cloud.points.front().intensity, 7.0F);
}

/// What verification makes of it: a key frame may not contradict the map that it is made of.
TEST(VisibleCloud, SeesThroughNothingOfTheMap) {
  MadeMap map = two_walls();
  map.add_rectangle({-20.0, -20.0, 0.0}, {40.0, 0.0, 0.0}, {0.0, 40.0, 0.0});
  map.add_rectangle({-12.0, -20.0, 0.0}, {0.0, 40.0, 0.0}, {0.0, 0.0, 5.0});
  map.add_rectangle({3.0, 4.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 2.0});
  std::vector<Eigen::Vector3f> points;
  for (const Point& p : seen(map).points) points.push_back(p.position());
  const FreeSpaceImage image(points, kLidar.cast<float>());
  int consistent = 0;
  for (const Point& p : map.cloud().points) {
    const auto test = image.test_free_space(p.position());
    EXPECT_NE(test, FreeSpaceImage::FreeSpaceTest::kViolation) << p.position().transpose();
    consistent += test == FreeSpaceImage::FreeSpaceTest::kConsistent ? 1 : 0;
  }
  EXPECT_GT(consistent, 10'000);
}

}  // namespace
}  // namespace lidar_mapping::map_import
