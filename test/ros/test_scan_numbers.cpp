// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/scan_numbers.hpp"

namespace lidar_mapping::ros_border {
namespace {

ScanNumbers after(const std::vector<std::uint32_t>& numbers) {
  ScanNumbers result;
  for (const std::uint32_t number : numbers) result.add(number);
  return result;
}

TEST(ScanNumbers, CountsWhatWasPlayedBeforeTheConnectionAndWhatIsMissingBetween) {
  EXPECT_EQ(after({0, 1, 2, 3}).missing(), 0U);
  EXPECT_EQ(after({6, 7, 8}).before_first(), 6U);
  EXPECT_EQ(after({6, 7, 8}).between(), 0U);
  EXPECT_EQ(after({6, 7, 10, 11}).between(), 2U);
  EXPECT_EQ(after({6, 7, 10, 11}).missing(), 8U);
}

/// No false alarm where nothing can be known.
TEST(ScanNumbers, ClaimsNothingOfSourcesThatDoNotNumberOrThatRanBefore) {
  EXPECT_EQ(after({0, 0, 0, 0}).missing(), 0U);
  EXPECT_EQ(after({5, 5, 5}).between(), 0U);
  EXPECT_EQ(after({48211, 48212, 48213}).missing(), 0U);
  EXPECT_EQ(after({48211, 48213}).missing(), 0U) << "perhaps every second scan was recorded";
  EXPECT_EQ(after({48211, 48212, 48214}).missing(), 1U);
}

TEST(ScanNumbers, KnowsRecordingsThatWereThinned) {
  EXPECT_EQ(after({0, 2, 4, 6}).missing(), 0U);
  EXPECT_EQ(after({0, 2, 4, 8, 10}).missing(), 1U);
  EXPECT_EQ(after({0, 6, 8, 10}).missing(), 2U) << "the first step was none";
}

TEST(ScanNumbers, BeginsAnewWhereTheNumbersGoBack) {
  EXPECT_EQ(after({0, 1, 4, 0, 1, 2}).missing(), 2U);
  EXPECT_EQ(after({0, 1, 4, 3, 4, 6}).missing(), 3U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
