// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include <gtest/gtest.h>

#include "sight.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

/// A view of single points at these distances ahead.
BirdsEyeView view_of(const std::vector<float>& distances) {
  std::vector<Eigen::Vector3f> points;
  for (const float distance : distances) points.emplace_back(distance, 0.5F, 1.0F);
  return {points, std::vector<bool>(points.size(), true)};
}

TEST(RangeOfSight, HoldsFourFifthsOfTheOccupiedCells) {
  EXPECT_NEAR(range_of_sight(view_of({2.5F, 4.5F, 6.5F, 8.5F, 50.5F})), 8.5, 0.1)
      << "a view through the door does not count";
  EXPECT_NEAR(range_of_sight(view_of({2.5F, 44.5F, 46.5F, 48.5F, 50.5F})), 48.5, 0.1);
}

TEST(RangeOfSight, DoesNotDependOnTheDensityOfPoints) {
  std::vector<float> distances(1000, 2.5F);
  distances.insert(distances.end(), {24.5F, 26.5F, 28.5F, 30.5F});
  EXPECT_NEAR(range_of_sight(view_of(distances)), 28.5, 0.1);
}

TEST(RangeOfSight, OfNothingIsZero) { EXPECT_EQ(range_of_sight({}), 0.0); }

TEST(Limits, FollowTheRangeOfSightUnlessTheyAreSet) {
  LoopClosingConfig config;
  config.max_loop_distance = -1.0;
  EXPECT_EQ(loop_distance_limit(12.0, config), 12.0);
  EXPECT_EQ(least_path_length(12.0, config), 24.0);
  EXPECT_EQ(search_interval(8.0, config), 4.0);
  config.max_loop_distance = 10.0;
  config.accum_distance_thresh = 0.0;
  config.min_edge_interval = 15.0;
  EXPECT_EQ(loop_distance_limit(12.0, config), 10.0);
  EXPECT_EQ(least_path_length(12.0, config), 0.0);
  EXPECT_EQ(search_interval(8.0, config), 15.0);
}

TEST(Limits, OfTheSpacingEndWhereOdometryErrsMoreThanALoop) {
  EXPECT_EQ(least_path_length(45.0, {}), 50.0);
  EXPECT_EQ(search_interval(45.0, {}), 5.0);
}

TEST(GrowthOfError, BeginsWhereKeyFramesAreNotClose) {
  EXPECT_TRUE(is_close(5.0, 40.0));
  EXPECT_FALSE(is_close(5.1, 40.0));
  EXPECT_EQ(growth_of_error(5.0, 40.0), 1.0);
  EXPECT_EQ(growth_of_error(5.1, 40.0), 5.0);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
