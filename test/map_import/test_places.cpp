// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "near.hpp"
#include "places.hpp"

namespace lidar_mapping::map_import {
namespace {

using test::near;

constexpr double kSpacing = 5.0;  // m; chosen: the default of import_map

/// The open cells of a level street along x.
std::vector<OpenCell> street(int columns, int rows, double height = 0.0) {
  std::vector<OpenCell> cells;
  for (int i = 0; i < columns; ++i) {
    for (int k = 0; k < rows; ++k) {
      OpenCell cell;
      cell.p_map = {i + 0.5, k + 0.5, height};
      cell.clearance = 1 + std::min({i, k, columns - 1 - i, rows - 1 - k});
      cells.push_back(cell);
    }
  }
  return cells;
}

double nearest_distance(const Eigen::Vector3d& p, const std::vector<Place>& places) {
  double nearest = 1e9;
  for (const Place& place : places) {
    nearest = std::min(nearest, (place.T_map_base.translation - p).norm());
  }
  return nearest;
}

TEST(PlacesOnGround, KeepTheirDistanceAndLeaveNoGap) {
  const std::vector<OpenCell> ground = street(58, 6);
  const std::vector<Place> places = places_on_ground(ground, kSpacing, 0.0);
  ASSERT_GE(places.size(), 11U);
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Eigen::Vector3d between =
          places[i].T_map_base.translation - places[k].T_map_base.translation;
      EXPECT_GE(between.norm(), kSpacing) << i << " " << k;
    }
  }
  for (const OpenCell& cell : ground) {
    EXPECT_LT(nearest_distance(cell.p_map, places), kSpacing) << cell.p_map.transpose();
  }
}

TEST(PlacesOnGround, StandInTheMiddleOneAfterTheOther) {
  const std::vector<Place> places = places_on_ground(street(58, 6), kSpacing, 0.0);
  ASSERT_GE(places.size(), 11U);
  EXPECT_NEAR(places.front().T_map_base.translation.y(), 3.0, 0.6);
  for (std::size_t i = 1; i < places.size(); ++i) {
    EXPECT_GT(places[i].stamp, places[i - 1].stamp);
    EXPECT_LT((places[i].T_map_base.translation - places[i - 1].T_map_base.translation).norm(),
              2.0 * kSpacing);
  }
}

TEST(PlacesOnGround, StandOnEachStorey) {
  std::vector<OpenCell> ground = street(58, 6);
  const std::vector<OpenCell> upper = street(58, 6, 3.0);
  ground.insert(ground.end(), upper.begin(), upper.end());
  const std::vector<Place> places = places_on_ground(ground, kSpacing, 0.0);
  const auto is_low = [](const Place& place) { return place.T_map_base.translation.z() < 1.0; };
  const auto low = std::count_if(places.begin(), places.end(), is_low);
  EXPECT_EQ(static_cast<std::size_t>(low), places_on_ground(street(58, 6), kSpacing, 0.0).size());
  EXPECT_EQ(2 * low, static_cast<std::ptrdiff_t>(places.size()));
  EXPECT_TRUE(std::is_partitioned(places.begin(), places.end(), is_low)) << "one after the other";
}

TEST(PlacesOnGround, AreTiltedAsTheGroundAndLieAboveIt) {
  OpenCell cell;
  cell.p_map = {10.0, 20.0, 30.0};
  cell.up = Eigen::Vector3d(-0.1, 0.0, 1.0).normalized();
  cell.clearance = 1;
  const std::vector<Place> places = places_on_ground({cell}, kSpacing, 0.5);
  ASSERT_EQ(places.size(), 1U);
  const Pose& pose = places.front().T_map_base;
  EXPECT_TRUE(near(pose.rotation * Eigen::Vector3d::UnitZ(), cell.up, 1e-9));
  EXPECT_NEAR(yaw_of(pose.rotation), 0.0, 1e-9);
  EXPECT_TRUE(near(pose.translation, cell.p_map + 0.5 * cell.up, 1e-9));
}

/// There and back along x, a pose for each metre and second.
Trajectory there_and_back() {
  Trajectory trajectory;
  for (int i = 0; i <= 40; ++i) {
    StampedPose pose;
    pose.stamp = from_seconds(100.0 + i);
    pose.pose.translation.x() = i <= 20 ? i : 40 - i;
    trajectory.poses.push_back(pose);
  }
  return trajectory;
}

TEST(PlacesAlong, ATrajectoryAreOnItOnce) {
  const std::vector<Place> places = places_along(there_and_back(), kSpacing);
  ASSERT_EQ(places.size(), 5U);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double x = kSpacing * static_cast<double>(i);
    EXPECT_EQ(places[i].stamp, from_seconds(100.0 + x));
    EXPECT_TRUE(near(places[i].T_map_base.translation, Eigen::Vector3d(x, 0.0, 0.0), 1e-12));
  }
}

TEST(PlacesAlong, ATrajectoryWithoutStampsAreNumbered) {
  Trajectory trajectory = there_and_back();
  trajectory.has_stamps = false;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    trajectory.poses[i].stamp = static_cast<Stamp>(i);
  }
  const std::vector<Place> places = places_along(trajectory, kSpacing);
  ASSERT_EQ(places.size(), 5U);
  EXPECT_EQ(places[1].stamp, from_seconds(6.0));
}

TEST(PlacesAlong, OfTwoPosesAtOneStampTheFirstCounts) {
  Trajectory trajectory;
  for (const double x : {0.0, 50.0}) {
    StampedPose pose;
    pose.stamp = from_seconds(3.0);
    pose.pose.translation.x() = x;
    trajectory.poses.push_back(pose);
  }
  EXPECT_EQ(places_along(trajectory, kSpacing).size(), 1U);
}

}  // namespace
}  // namespace lidar_mapping::map_import
