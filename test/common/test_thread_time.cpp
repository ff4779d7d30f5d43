// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/thread_time.hpp"

namespace lidar_mapping {
namespace {

/// Computes until `time` has measured this many seconds more.
void work(const ThreadTime& time, double seconds) {
  const double end = time.seconds() + seconds;
  volatile double sum = 0.0;
  while (time.seconds() < end) sum = sum + std::sqrt(sum + 2.0);
}

constexpr double kShort = 0.002, kLong = 0.02;  // s of computing

TEST(ThreadTime, DoesNotCountWhatInnerOnesMeasured) {
  const ThreadTime outer;
  for (int i = 0; i < 2; ++i) {
    const ThreadTime inner;
    work(inner, kLong);
    EXPECT_GE(inner.seconds(), kLong);
  }
  EXPECT_LT(outer.seconds(), 0.5 * kLong);
  work(outer, kShort);
  EXPECT_GE(outer.seconds(), kShort);
}

// What the innermost measured is the middle one's neither, nor is it taken off the outer one twice.
TEST(ThreadTime, CountsEachMomentOnce) {
  const ThreadTime outer;
  work(outer, kShort);
  {
    const ThreadTime middle;
    {
      const ThreadTime inner;
      work(inner, kLong);
    }
    EXPECT_LT(middle.seconds(), 0.5 * kLong);
    work(middle, kShort);
  }
  EXPECT_GE(outer.seconds(), kShort);
  EXPECT_LT(outer.seconds(), kShort + 0.5 * kLong);
}

TEST(ThreadTime, BeginsAtZeroAfterOthersHaveEnded) {
  {
    const ThreadTime before;
    work(before, kShort);
  }
  const ThreadTime time;
  work(time, kShort);
  EXPECT_GE(time.seconds(), kShort);
  EXPECT_LT(time.seconds(), kShort + 0.5 * kLong);
}

}  // namespace
}  // namespace lidar_mapping
