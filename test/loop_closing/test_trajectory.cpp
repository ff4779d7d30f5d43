// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "candidates/graph_distance.hpp"
#include "candidates/position_grid.hpp"
#include "drive.hpp"
#include "trajectory.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

Trajectory straight(std::size_t count) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < count; ++i) {
    trajectory.append(key_frame(i, planar(2.0 * static_cast<double>(i), 0.0, 0.0)));
  }
  return trajectory;
}

// Poses that are not optimised yet follow the newest optimised pose.
TEST(Trajectory, PredictsByOdometryFromTheNewestOptimisedPose) {
  Trajectory trajectory = straight(5);
  const auto moved = trajectory.update({1, true, {{2, 0, planar(4.0, 10.0, kPi / 2.0)}}});
  EXPECT_EQ(moved.size(), 3U);
  EXPECT_NEAR(trajectory[4].T_map_base.translation.y(), 14.0, 1e-9);
  EXPECT_NEAR(trajectory[4].T_map_base.translation.x(), 4.0, 1e-9);
  trajectory.append(key_frame(5, planar(10.0, 0.0, 0.0)));
  EXPECT_NEAR(trajectory[5].T_map_base.translation.y(), 16.0, 1e-9);
  EXPECT_NEAR(trajectory[1].T_map_base.translation.x(), 2.0, 1e-9);
}

TEST(Trajectory, DistinguishesJumpsInHeightFromRampsAndStairs) {
  for (const double slope : {0.0, 0.15, -0.15, 0.6}) {
    Trajectory trajectory;
    for (std::size_t i = 0; i < 20; ++i) {
      const double climbed = slope * std::clamp(2.0 * (static_cast<double>(i) - 5.0), 0.0, 10.0);
      Pose pose = planar(2.0 * static_cast<double>(i), 0.0, 0.0, climbed);
      trajectory.append(key_frame(i, pose));
    }
    EXPECT_EQ(trajectory[19].height_jumps, 0.0) << slope;
    trajectory.append(key_frame(20, planar(40.0, 0.0, 0.0, 10.0 * slope - 2.6)));
    EXPECT_NEAR(trajectory[20].height_jumps, 2.6, 1e-9) << slope;
  }
}

TEST(Trajectory, StoresPosesAndPositionsBeforeTheirKeyFrame) {
  Trajectory trajectory = straight(2);
  trajectory.update({1, true, {{2, 0, planar(7.0, 0.0, 0.0)}}});
  GnssPosition position;
  position.stamp = key_frame(2, {}).stamp;
  EXPECT_FALSE(trajectory.add_gnss(position));
  trajectory.append(key_frame(2, planar(4.0, 0.0, 0.0)));
  EXPECT_EQ(trajectory[2].T_map_base.translation.x(), 7.0);
  EXPECT_TRUE(trajectory[2].gnss);
  position.stamp = key_frame(1, {}).stamp;
  EXPECT_EQ(trajectory.add_gnss(position), std::optional<std::size_t>(1));
  position.stamp += 1;
  EXPECT_FALSE(trajectory.add_gnss(position));
}

TEST(Trajectory, RefusesIndicesThatDoNotIncrease) {
  Trajectory trajectory = straight(3);
  EXPECT_THROW(trajectory.append(key_frame(2, {})), InputError);
}

TEST(Trajectory, DoesNotPredictAcrossSegments) {
  Trajectory trajectory = straight(2);
  KeyFrame next = key_frame(2, planar(500.0, 0.0, 0.0));
  next.segment = 1;
  trajectory.append(next);
  EXPECT_EQ(trajectory[2].travelled, trajectory[1].travelled);
  EXPECT_EQ(trajectory.path_length_between(1, 0), 2.0);
  EXPECT_EQ(trajectory.path_length_between(1, 2), std::numeric_limits<double>::infinity());
}

TEST(GraphDistance, IsTheShortestPathThroughLoops) {
  GraphDistance graph_distance;
  for (int i = 0; i <= 100; ++i) graph_distance.append(2.0);
  EXPECT_DOUBLE_EQ(graph_distance.to(0), 200.0);
  graph_distance.update_loops({{10, 90}});
  EXPECT_DOUBLE_EQ(graph_distance.to(10), 20.0);
  EXPECT_DOUBLE_EQ(graph_distance.to(0), 40.0);
  EXPECT_DOUBLE_EQ(graph_distance.to(50), 100.0);
  graph_distance.append(3.0);
  EXPECT_DOUBLE_EQ(graph_distance.to(0), 43.0);
  EXPECT_DOUBLE_EQ(graph_distance.to(101), 0.0);
}

// Segments in a row, each with two key frames and tied to the next by one loop. In this order of
// the loops a round follows only one of them.
TEST(GraphDistance, FollowsAnyNumberOfLoops) {
  constexpr std::size_t kSegments = 30;
  GraphDistance graph_distance;
  std::vector<GraphDistance::LoopEdge> links;
  for (std::size_t segment = 0; segment < kSegments; ++segment) {
    graph_distance.append(std::numeric_limits<double>::infinity());
    graph_distance.append(2.0);
    if (segment > 0) links.emplace_back(2 * segment - 2, 2 * segment + 1);
  }
  graph_distance.update_loops(links);
  EXPECT_DOUBLE_EQ(graph_distance.to(2 * kSegments - 4), 0.0);
  EXPECT_DOUBLE_EQ(graph_distance.to(0), 2.0 * (kSegments - 2));
  EXPECT_DOUBLE_EQ(graph_distance.to(1), 2.0 * (kSegments - 1));
}

TEST(GraphDistance, IsInfiniteBetweenSegmentsWithoutALoop) {
  const double none = std::numeric_limits<double>::infinity();
  GraphDistance graph_distance;
  for (const double step : {0.0, 2.0, 2.0, none, 2.0}) graph_distance.append(step);
  EXPECT_EQ(graph_distance.to(1), none);
  EXPECT_DOUBLE_EQ(graph_distance.to(3), 2.0);
  graph_distance.update_loops({{0, 4}});
  EXPECT_DOUBLE_EQ(graph_distance.to(2), 4.0);
}

TEST(PositionGrid, AgreesWithALinearSearchWhileNodesMove) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> coordinate(-300.0, 300.0);
  const auto somewhere = [&] {
    return Eigen::Vector2d(coordinate(generator), coordinate(generator));
  };
  PositionGrid grid;
  std::vector<Eigen::Vector2d> places(1000);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      places[i] = somewhere();
      grid.set_position(i, places[i]);
    }
    for (const double radius : {5.0, 40.0, 700.0}) {
      const Eigen::Vector2d centre = somewhere();
      std::vector<std::size_t> expected;
      for (std::size_t i = 0; i < places.size(); ++i) {
        if ((places[i] - centre).norm() <= radius) expected.push_back(i);
      }
      EXPECT_EQ(grid.within(centre, radius), expected);
    }
  }
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
