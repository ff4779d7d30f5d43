// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "floor/plane_search.hpp"
#include "near.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr double kTolerance = 0.05;  // m
constexpr double kLean = 0.35;       // rad

/// A grid of `edge` times `edge` points, a metre apart, with z = height + slope x.
Points grid(int edge, double height, double slope) {
  Points points;
  for (int i = 0; i < edge; ++i) {
    for (int k = 0; k < edge; ++k) {
      const double x = i - 0.5 * edge, y = k - 0.5 * edge;
      points.emplace_back(x, y, height + slope * x);
    }
  }
  return points;
}

void append(Points& points, const Points& more) {
  points.insert(points.end(), more.begin(), more.end());
}

/// A wall of `count` columns of ten points at x = 6.
Points wall(int count) {
  Points points;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 10; ++k) points.emplace_back(6.0, 0.3 * i, 0.4 * k - 1.0);
  }
  return points;
}

TEST(PlaneSearch, FindsTheFloorBesideAWall) {
  Points points = grid(12, -1.7, 0.1);
  append(points, wall(12));
  const auto plane = search_plane(points, kTolerance, kLean);
  ASSERT_TRUE(plane);
  const double length = std::hypot(1.0, 0.1);
  EXPECT_TRUE(test::near(plane->normal, Eigen::Vector3d(-0.1, 0.0, 1.0) / length, 1e-9));
  EXPECT_NEAR(plane->offset, 1.7 / length, 1e-9);
}

// The wall has more points, but no floor leans like it.
TEST(PlaneSearch, FindsNothingThatLeansMoreThanAllowed) {
  EXPECT_FALSE(search_plane(wall(30), kTolerance, kLean));
  const double slope = std::tan(0.3);
  EXPECT_TRUE(search_plane(grid(8, 0.0, slope), kTolerance, 0.31));
  EXPECT_FALSE(search_plane(grid(8, 0.0, slope), kTolerance, 0.29));
}

TEST(PlaneSearch, TakesTheLevelWithMorePoints) {
  for (const double upper : {0.4, -0.4}) {
    Points points = grid(10, 0.0, 0.0);
    append(points, grid(7, upper, 0.0));
    const auto plane = search_plane(points, kTolerance, 0.01);
    ASSERT_TRUE(plane);
    EXPECT_NEAR(plane->offset, 0.0, 1e-9) << upper;
  }
}

TEST(PlaneSearch, NormalPointsUpAndDistancesHaveTheirSign) {
  const auto plane = search_plane(grid(6, -2.0, 0.0), kTolerance, kLean);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->distance({3.0, 4.0, -2.0}), 0.0, 1e-9);
  EXPECT_NEAR(plane->distance({3.0, 4.0, -1.5}), 0.5, 1e-9) << "above";
  EXPECT_NEAR(plane->distance({3.0, 4.0, -3.0}), -1.0, 1e-9) << "below";
}

TEST(PlaneSearch, NeedsThreePointsThatAreNotOnALine) {
  EXPECT_FALSE(search_plane({}, kTolerance, kLean));
  EXPECT_FALSE(search_plane({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, kTolerance, kLean));
  Points line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.5 * i, 0.25 * i, 0.0);
  EXPECT_FALSE(search_plane(line, kTolerance, kLean));
  line.emplace_back(0.0, 9.0, 0.0);
  for (int i = 0; i < 50; ++i) line.emplace_back(1.0, 0.3 * i, 0.0);
  EXPECT_TRUE(search_plane(line, kTolerance, kLean));
}

// 10,000 points are more than it counts; the floor's are the last ones.
TEST(PlaneSearch, LooksAtAllPartsOfALargeCloud) {
  Points points;
  for (int i = 0; i < 4000; ++i) points.emplace_back(0.01 * i, std::sin(1.0 * i), 0.02 * (i % 97));
  append(points, grid(78, -1.7, 0.0));
  const auto plane = search_plane(points, kTolerance, kLean);
  ASSERT_TRUE(plane);
  EXPECT_TRUE(test::near(plane->normal, Eigen::Vector3d::UnitZ(), 1e-9));
  EXPECT_NEAR(plane->offset, 1.7, 1e-9);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
