// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "checks/axis_limits.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr double kLeast = 1.0;

/// A gait with noise, in the steps of a converter of 16 bits, cut off at `limit`.
Eigen::Vector3d rate(int i, double limit) {
  const auto cut = [&](double value) {
    const double step = 35.0 / 32768.0;
    return std::clamp(step * std::round(value / step), -limit, limit);
  };
  const double noise = 0.004 * std::sin(12.9898 * i);
  return {cut(0.3 * std::sin(0.02 * i) + noise), cut(4.0 * std::sin(0.05 * i) + noise), 0.0};
}

TEST(AxisLimits, FindsTheEndOfTheRange) {
  AxisLimits limits(kLeast);
  for (int i = 0; i < 400; ++i) limits.add(rate(i, 3.0));
  ASSERT_TRUE(limits.lowest());
  EXPECT_EQ(*limits.lowest(), 3.0);
  EXPECT_TRUE(limits.reaches_limit({0.0, -3.0, 0.0}));
  EXPECT_FALSE(limits.reaches_limit({0.0, 2.99, 0.0}));
  EXPECT_FALSE(limits.reaches_limit({3.0, 0.0, 0.0})) << "another axis";
}

TEST(AxisLimits, DoesNotMistakeAPeakForALimit) {
  AxisLimits limits(kLeast);
  for (int i = 0; i < 4000; ++i) limits.add(rate(i, 100.0));
  EXPECT_FALSE(limits.lowest());
}

// At rest a coarse converter says the same for long.
TEST(AxisLimits, DoesNotMistakeRestForALimit) {
  AxisLimits limits(kLeast);
  for (int i = 0; i < 1000; ++i) limits.add({0.01, 0.0, -0.02});
  EXPECT_FALSE(limits.lowest());
}

TEST(AxisLimits, DropsALimitThatWasExceeded) {
  AxisLimits limits(kLeast);
  for (int i = 0; i < 5; ++i) limits.add({2.0, 0.0, 0.0});
  EXPECT_TRUE(limits.reaches_limit({2.0, 0.0, 0.0}));
  limits.add({2.5, 0.0, 0.0});
  EXPECT_FALSE(limits.reaches_limit({2.5, 0.0, 0.0}));
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
