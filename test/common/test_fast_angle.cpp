// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/fast_angle.hpp"

namespace lidar_mapping {
namespace {

TEST(FastAngle, IsThatOfAtan2AllAround) {
  for (int i = 0; i < 3600; ++i) {
    const double angle = (i + 0.5) * kPi / 1800.0 - kPi;
    for (const double length : {1e-3, 1.0, 500.0}) {
      const auto x = static_cast<float>(length * std::cos(angle));
      const auto y = static_cast<float>(length * std::sin(angle));
      EXPECT_NEAR(fast_angle(y, x), angle, 2e-5) << angle << " at " << length;
    }
  }
}

TEST(FastAngle, IsExactAlongTheAxesAndZeroWithoutADirection) {
  EXPECT_EQ(fast_angle(0.0F, 2.0F), 0.0F);
  EXPECT_FLOAT_EQ(fast_angle(2.0F, 0.0F), static_cast<float>(0.5 * kPi));
  EXPECT_FLOAT_EQ(fast_angle(-2.0F, 0.0F), static_cast<float>(-0.5 * kPi));
  EXPECT_FLOAT_EQ(fast_angle(0.0F, -2.0F), static_cast<float>(kPi));
  EXPECT_EQ(fast_angle(0.0F, 0.0F), 0.0F);
}

}  // namespace
}  // namespace lidar_mapping
