// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "localization/display_resolution.hpp"

namespace lidar_mapping::ros_border {
namespace {

TEST(DisplayResolution, BecomesCoarserWithTheMap) {
  EXPECT_EQ(display_resolution(0), 0.5);
  EXPECT_EQ(display_resolution(100'000), 0.5) << "a town";
  EXPECT_EQ(display_resolution(1'600'000), 1.0) << "sixteen towns";
  EXPECT_EQ(display_resolution(20'000'000), 4.0) << "200 km";
}

}  // namespace
}  // namespace lidar_mapping::ros_border
