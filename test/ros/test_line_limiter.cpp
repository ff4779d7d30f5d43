// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/line_limiter.hpp"

namespace lidar_mapping::ros_border {
namespace {

TEST(LineLimiter, SaysTheFirstLineAndThenTheNewestOfEveryTenSeconds) {
  LineLimiter limiter;
  EXPECT_EQ(limiter.add("1 loop", 100.0), "1 loop");
  EXPECT_EQ(limiter.add("2 loops", 100.1), std::nullopt);
  EXPECT_EQ(limiter.add("3 loops", 109.9), std::nullopt);
  EXPECT_EQ(limiter.add("4 loops", 110.0), "4 loops");
  EXPECT_EQ(limiter.rest(), std::nullopt) << "it has been said";
}

TEST(LineLimiter, KeepsTheNewestLineUntilNoOtherFollows) {
  LineLimiter limiter;
  EXPECT_EQ(limiter.rest(), std::nullopt);
  limiter.add("1 loop", 5.0);
  limiter.add("2 loops", 6.0);
  limiter.add("3 loops", 7.0);
  EXPECT_EQ(limiter.rest(), "3 loops");
  EXPECT_EQ(limiter.rest(), std::nullopt);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
