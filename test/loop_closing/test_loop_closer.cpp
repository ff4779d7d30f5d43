#include <gtest/gtest.h>

#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include "drive.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

// F70: a square that ends where it began closes on the first key frames.
// F68: without GNSS, although odometry ends metres away from the start.
TEST(LoopCloser, ClosesASquareOnItsFirstKeyFrames) {
  const ToyWorld world = make_town(150.0, 100.0, 1);
  const auto truth = along({{0, 0}, {100, 0}, {100, 100}, {0, 100}, {0, 0}, {20, 0}});
  const auto odometry = drifting(truth, 1.01, 1e-4);
  const DriveOutcome outcome = drive(world, truth, odometry);
  EXPECT_EQ(outcome.false_loops, 0);
  ASSERT_FALSE(outcome.loops.empty());
  const auto first = std::min_element(outcome.loops.begin(), outcome.loops.end(),
                                      [](const Loop& a, const Loop& b) { return a.from < b.from; });
  EXPECT_LE(first->from, 5U);
}

// F74: the way back through the same street, without an absolute heading.
TEST(LoopCloser, ClosesAStreetDrivenTheOtherWay) {
  const ToyWorld world = make_town(150.0, 100.0, 2);
  const auto truth = along({{0, 0}, {100, 0}, {100, 3.5}, {0, 3.5}});
  const DriveOutcome outcome = drive(world, truth, drifting(truth, 1.01, 2e-4));
  EXPECT_EQ(outcome.false_loops, 0);
  EXPECT_GE(outcome.loops.size(), 6U);
}

TEST(LoopCloser, ExplainsEveryCandidate) {
  const ToyWorld world = make_town(150.0, 100.0, 2);
  const auto truth = along({{0, 0}, {80, 0}, {80, 3.5}, {0, 3.5}});
  const DriveOutcome outcome = drive(world, truth, truth);
  ASSERT_GE(outcome.verdicts.size(), outcome.loops.size());
  for (const LoopVerdict& verdict : outcome.verdicts) {
    EXPECT_FALSE(verdict.reason.empty());
    EXPECT_LT(verdict.from, verdict.to);
  }
}

TEST(LoopCloser, FindsNothingWhereNothingIsSeenAgain) {
  const ToyWorld world = make_town(200.0, 100.0, 3);
  const auto truth = along({{-150, 0}, {150, 0}});
  EXPECT_TRUE(drive(world, truth, truth).loops.empty());
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
