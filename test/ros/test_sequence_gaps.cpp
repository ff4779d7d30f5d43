// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/node.hpp"

namespace lidar_mapping::ros_border {
namespace {

TEST(SequenceGaps, CountsWhatIsMissing) {
  SequenceGaps gaps;
  EXPECT_EQ(gaps.check("/a", 7), 0U);
  EXPECT_EQ(gaps.check("/a", 8), 0U);
  EXPECT_EQ(gaps.check("/a", 12), 3U);
  EXPECT_EQ(gaps.check("/a", 1), 0U) << "a publisher that began again has lost nothing";
  EXPECT_EQ(gaps.check("/b", 9), 0U) << "another publisher counts for itself";
}

TEST(SequenceGaps, SourcesThatDoNotNumberHaveNone) {
  SequenceGaps gaps;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(gaps.check("/bag", 0), 0U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
