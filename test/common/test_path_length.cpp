// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/path_length.hpp"

namespace lidar_mapping {
namespace {

KeyFramePoses poses_at(const std::vector<Eigen::Vector3d>& positions) {
  KeyFramePoses poses;
  for (const Eigen::Vector3d& position : positions) {
    poses.poses.push_back({0, 0, {Eigen::Quaterniond::Identity(), position}});
  }
  return poses;
}

TEST(PathLength, AddsUpTheStepsInSpace) {
  const KeyFramePoses poses =
      poses_at({{1.0, 0.0, 0.0}, {1.0, 3.0, 4.0}, {1.0, 3.0, 4.0}, {3.0, 3.0, 4.0}});
  EXPECT_EQ(travelled_distances(poses), (std::vector<double>{0.0, 5.0, 5.0, 7.0}));
  EXPECT_EQ(path_length(poses), 7.0) << "not the distance of the ends";
}

TEST(PathLength, IsZeroOfOnePositionAndOfNone) {
  EXPECT_EQ(travelled_distances(poses_at({{1.0, 2.0, 3.0}})), (std::vector<double>{0.0}));
  EXPECT_EQ(path_length(poses_at({{1.0, 2.0, 3.0}})), 0.0);
  EXPECT_TRUE(travelled_distances(poses_at({})).empty());
  EXPECT_EQ(path_length(poses_at({})), 0.0);
}

TEST(PathLength, LeavesOutStepsBetweenPaths) {
  const std::vector<double> places = {0.0, 2.0, 90.0, 91.0};
  const auto position_of = [&](std::size_t i) { return places[i] * Eigen::Vector3d::UnitX(); };
  const auto is_apart = [](std::size_t i) { return i == 2; };
  EXPECT_EQ(travelled_distances(places.size(), position_of, is_apart),
            (std::vector<double>{0.0, 2.0, 2.0, 3.0}));
}

TEST(PathLength, TakesPositionsOfAnyKind) {
  const std::vector<Eigen::Vector2d> plan = {{0.0, 0.0}, {0.0, 2.0}, {1.0, 2.0}};
  const auto position_of = [&](std::size_t i) -> const auto& { return plan[i]; };
  EXPECT_EQ(path_length(plan.size(), position_of), 3.0);
  EXPECT_EQ(path_length(0, position_of), 0.0);
}

}  // namespace
}  // namespace lidar_mapping
