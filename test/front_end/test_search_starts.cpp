// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "matching/search_starts.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionState;

// After a gap the vehicle may be anywhere between where it was and where its speed would have
// put it.
TEST(SearchStarts, LeaveNoGapBetweenTheAnchorAndThePrediction) {
  MotionState prediction;
  prediction.T_map_sensor.translation.x() = 25.0;
  const auto starts = starts_around(prediction, {Pose{}});
  for (double x = 0.0; x <= 25.0; x += 0.5) {
    const auto is_near = [&](const MotionState& start) {
      return (start.T_map_sensor.translation - Eigen::Vector3d(x, 0.0, 0.0)).norm() < 1.0;
    };
    EXPECT_TRUE(std::any_of(starts.begin(), starts.end(), is_near)) << x;
  }
}

/// True if a start at 8 m/s turns by that much within the step.
bool has_turn(const std::vector<MotionState>& starts, double yaw) {
  return std::any_of(starts.begin(), starts.end(), [yaw](const MotionState& start) {
    return std::abs(start.twist[0] - 8.0) < 1.0 &&
           std::abs(log_so3(start.T_map_sensor.rotation).z() - yaw) < 0.01;
  });
}

// A match reaches 0.1 rad; between scans that follow each other slowly a vehicle turns by more.
TEST(SearchStarts, OfAFirstMotionRotateIfTheIntervalIsLong) {
  const auto slow = starts_at_speed(Pose{}, 0.5);
  EXPECT_TRUE(has_turn(slow, 0.3));
  EXPECT_TRUE(has_turn(slow, -0.3));
  EXPECT_TRUE(has_turn(slow, 0.0));
  const auto fast = starts_at_speed(Pose{}, 0.1);
  EXPECT_TRUE(has_turn(fast, 0.0));
  EXPECT_FALSE(has_turn(fast, 0.15));
}

// A LiDAR may look any way on its vehicle.
TEST(SearchStarts, LieInTheDirectionOfTravel) {
  const auto has = [](const std::vector<MotionState>& starts, double x, double y) {
    return std::any_of(starts.begin(), starts.end(), [&](const MotionState& start) {
      return (start.T_map_sensor.translation - Eigen::Vector3d(x, y, 0.0)).norm() < 0.7;
    });
  };
  MotionState sideways;
  sideways.twist[1] = -8.0;
  EXPECT_TRUE(has(starts_around(sideways, {}), 0.0, -6.0));
  EXPECT_FALSE(has(starts_around(sideways, {}), 6.0, 0.0));
  const auto first = starts_at_speed(Pose{}, 0.1);
  for (double angle = 0.0; angle < 6.2; angle += 0.25 * M_PI) {
    EXPECT_TRUE(has(first, 3.5 * std::cos(angle), 3.5 * std::sin(angle))) << angle;
  }
}

TEST(SearchStarts, AreNoMoreThanNeeded) {
  const auto around_one = starts_around(MotionState{}, {});
  EXPECT_EQ(starts_around(MotionState{}, {Pose{}}).size(), around_one.size());
  MotionState far;
  far.T_map_sensor.translation.x() = 1000.0;
  EXPECT_LE(starts_around(far, {Pose{}}).size(), 10 * around_one.size());
  EXPECT_LT(starts_at_speed(Pose{}, 3600.0).size(), 25000U) << "a start takes 3 kB and 10 us";
}

}  // namespace
}  // namespace lidar_mapping::front_end
