// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "decision/elevation_range.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using Vector = Eigen::Vector3f;

const Vector kLidar(0.0F, 0.0F, 2.0F);

TEST(ElevationRange, ContainsNothingBeforeAScanWasAdded) {
  EXPECT_FALSE(ElevationRange().contains({10.0F, 0.0F, 2.0F}, kLidar));
}

TEST(ElevationRange, ReachesFromTheLowestToTheHighestRay) {
  ElevationRange range;
  range.add({{10.0F, 0.0F, 3.0F}, {0.0F, -4.0F, 0.0F}, {-20.0F, 0.0F, 2.0F}}, kLidar);
  EXPECT_TRUE(range.contains({0.0F, 20.0F, 3.99F}, kLidar));  // slopes from -0.5 to 0.1
  EXPECT_FALSE(range.contains({0.0F, 20.0F, 4.01F}, kLidar));
  EXPECT_TRUE(range.contains({3.0F, 4.0F, -0.49F}, kLidar));
  EXPECT_FALSE(range.contains({3.0F, 4.0F, -0.51F}, kLidar));
}

TEST(ElevationRange, CountsFromThePositionOfTheLidar) {
  ElevationRange range;
  range.add({{10.0F, 0.0F, 3.0F}, {10.0F, 0.0F, 1.0F}}, kLidar);
  const Vector higher = kLidar + Vector(0.0F, 0.0F, 5.0F);
  EXPECT_TRUE(range.contains({10.0F, 0.0F, 2.0F}, kLidar));
  EXPECT_FALSE(range.contains({10.0F, 0.0F, 2.0F}, higher));
}

TEST(ElevationRange, GrowsWithEachScan) {
  ElevationRange range;
  range.add({{10.0F, 0.0F, 2.0F}}, kLidar);
  EXPECT_FALSE(range.contains({10.0F, 0.0F, 2.5F}, kLidar));
  range.add({{10.0F, 0.0F, 3.0F}}, kLidar);
  EXPECT_TRUE(range.contains({10.0F, 0.0F, 2.5F}, kLidar));
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
