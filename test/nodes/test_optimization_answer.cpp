// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "back_end/optimization_answer.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kBegin = 1317384506123456789;

MapOptimization example() {
  MapOptimization done;
  done.report.success = true;
  done.report.message = "optimised 408 key frames in 7 iterations";
  done.report.key_frames = 408;
  done.report.loops_used = 80;
  done.report.loops_refused = 2;
  done.report.gnss_used = 120;
  done.report.cost_before = done.report.cost_after = 31.7;
  done.report.seconds = 0.6249;
  done.moved = {408, 0.004, 0.0213, 231, kBegin + 84300000000};
  done.corrected = {408, 0.35, 1.2, 300, kBegin + 120300000000};
  done.begin = kBegin;
  done.session = "/home/somebody/sessions/2026-01-02";
  done.save_map = "/save_map";
  return done;
}

bool says(const OptimizeMap::Response& answer, const std::string& text) {
  return answer.message.find(text) != std::string::npos;
}

TEST(OptimizationAnswer, StatesMovementConstraintsAndTheNextCall) {
  const OptimizeMap::Response answer = to_answer(example());
  for (const char* text :
       {"408 key frames optimised in 0.62 s",
        "moved by 0.004 m on average and by at most 0.021 m (key frame 231, 84.3 s into the drive)",
        "0.350 m on average and by at most 1.20 m (key frame 300, 120.3 s into the drive)",
        "Loops: 80 used, 2 refused", "GNSS fixes: 120 used, 0 refused",
        "Session: /home/somebody/sessions/2026-01-02", "call: rosservice call /save_map '{}'."}) {
    EXPECT_TRUE(says(answer, text)) << text << " is not in: " << answer.message;
  }
  EXPECT_FALSE(says(answer, "iterations"));
  EXPECT_EQ(answer.moved_farthest, 231U);
  EXPECT_EQ(answer.moved_farthest_stamp.toNSec(), static_cast<std::uint64_t>(kBegin) + 84300000000);
  EXPECT_DOUBLE_EQ(answer.corrected_largest, 1.2);
  EXPECT_EQ(answer.loops_refused, 2U);
  EXPECT_DOUBLE_EQ(answer.cost_after, 31.7);
}

TEST(OptimizationAnswer, StatesThatNothingMovedAndThatThereWereNoConstraints) {
  MapOptimization done = example();
  done.moved.largest = done.moved.mean = 0.0002;
  done.corrected.largest = 0.0;
  done.report.loops_used = done.report.loops_refused = done.report.gnss_used = 0;
  done.report.remarks = {"the constraints hardly determine the map"};
  const OptimizeMap::Response answer = to_answer(done);
  for (const char* text : {"No pose moved", "the same as by odometry alone", "No loops",
                           "No GNSS fixes", "Note: the constraints hardly determine the map."}) {
    EXPECT_TRUE(says(answer, text)) << text << " is not in: " << answer.message;
  }
}

TEST(OptimizationAnswer, SaysWhyItFailed) {
  MapOptimization done;
  done.report.message = "the solver failed and no pose has changed";
  EXPECT_EQ(to_answer(done).message, done.report.message);
  EXPECT_FALSE(to_answer(done).success);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
