// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include "drive.hpp"
#include "recorded_scans.hpp"
#include "test_data.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::RecordedClouds;

/// Processes the key frames [first, last] with an odometry that drifts.
void drive_part(LoopCloser& closer, const std::vector<Pose>& truth,
                const std::vector<Pose>& odometry, std::size_t first, std::size_t last,
                DriveOutcome& outcome) {
  for (std::size_t i = first; i <= last; ++i) {
    append(outcome, closer.process(key_frame(i, odometry[i])), truth);
  }
}

bool any_between(const std::vector<Loop>& loops, KeyFrameIndex first, KeyFrameIndex last) {
  return std::any_of(loops.begin(), loops.end(),
                     [&](const Loop& loop) { return loop.to >= first && loop.to <= last; });
}

// The published poses have errors of some decimetres at crossings.
bool is_plausible(const Loop& loop, const std::vector<Pose>& truth) {
  const Vector6d error = difference(truth[loop.from].inverse() * truth[loop.to], loop.T_from_to);
  return error.head<3>().norm() < 0.8 && error.tail<3>().norm() < 0.035;
}

TEST(Recorded, OnlyTheTwoRevisitsOfADriveClose) {
  REQUIRE_RECORDED(folder, "kitti00_keyframes");
  const auto truth = lidar_mapping::test::recorded_poses(folder);
  const auto odometry = drifting(truth, 1.005, 5e-5, 0.002);
  RecordedClouds clouds(folder);
  LoopCloser closer({}, clouds);
  DriveOutcome outcome;
  drive_part(closer, truth, odometry, 40, 90, outcome);
  drive_part(closer, truth, odometry, 150, 225, outcome);
  drive_part(closer, truth, odometry, 535, 565, outcome);
  EXPECT_TRUE(outcome.loops.empty());
  drive_part(closer, truth, odometry, 610, 660, outcome);
  drive_part(closer, truth, odometry, 980, 1010, outcome);
  for (const Loop& loop : outcome.loops) {
    EXPECT_TRUE(is_plausible(loop, truth)) << loop.from << " " << loop.to;
  }
  for (KeyFrameIndex begin = 617; begin < 655; begin += 6) {
    EXPECT_TRUE(any_between(outcome.loops, begin, begin + 6)) << begin;
  }
  EXPECT_TRUE(any_between(outcome.loops, 987, 995));
  EXPECT_TRUE(any_between(outcome.loops, 996, 1004));
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
