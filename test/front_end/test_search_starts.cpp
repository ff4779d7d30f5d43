#include <algorithm>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/search_starts.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionState;

// F41: after a gap the vehicle may be anywhere between where it was and where its speed would have
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

TEST(SearchStarts, AreNoMoreThanNeededNearTheAnchor) {
  const auto near = starts_around(MotionState{}, {Pose{}});
  MotionState far;
  far.T_map_sensor.translation.x() = 1000.0;
  EXPECT_LE(starts_around(far, {Pose{}}).size(), 5 * near.size());
}

}  // namespace
}  // namespace lidar_mapping::front_end
