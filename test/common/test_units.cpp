// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping {
namespace {

TEST(Units, HalfATurnIsPi) {
  EXPECT_DOUBLE_EQ(kPi, std::acos(-1.0));
  EXPECT_DOUBLE_EQ(180.0 * kRadPerDeg, kPi);
  EXPECT_DOUBLE_EQ(kPi * kDegPerRad, 180.0);
}

}  // namespace
}  // namespace lidar_mapping
