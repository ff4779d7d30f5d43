// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "drive_consistency.hpp"

namespace lidar_mapping::city::test {
namespace {

GnssDisagreement pair(std::size_t a, std::size_t b, double east) {
  return {a, b, {east, 0.0}, allowed_offset(1.0, 1.0)};
}

TEST(DriveConsistency, TheDriveThatContradictsMostIsNamed) {
  // Drive 1 lies 30 m beside all others, which agree.
  const auto found = contradicting_gnss(
      {pair(0, 1, 30.0), pair(1, 2, -30.0), pair(0, 2, 1.0), pair(1, 3, -29.0), pair(2, 3, 0.5)});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].drive, 1U);
  EXPECT_EQ(found[0].contradicted, 3U);
  EXPECT_EQ(found[0].confirmed, 0U);
  EXPECT_NEAR(found[0].offset, 30.0, 1e-12);
}

TEST(DriveConsistency, OfTwoTheOneThatOthersConfirmIsKept) {
  const auto found = contradicting_gnss({pair(0, 2, 0.0), pair(1, 2, 20.0)});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].drive, 1U);
  EXPECT_EQ(found[0].other_drive, 2U);
}

TEST(DriveConsistency, OfTwoAloneTheLaterIsLeftOut) {
  const auto found = contradicting_gnss({pair(0, 1, 20.0)});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].drive, 1U);
}

TEST(DriveConsistency, OffsetsWithinTheClaimedAccuracyAreNone) {
  EXPECT_TRUE(contradicting_gnss({pair(0, 1, 3.0), pair(0, 2, -3.0)}).empty());
  EXPECT_TRUE(contradicting_gnss({{0, 1, {20.0, 0.0}, allowed_offset(10.0, 10.0)}}).empty());
  EXPECT_TRUE(contradicting_gnss({}).empty());
}

TEST(DriveConsistency, ADriveWhoseLoopsAreMostlyRefusedContradicts) {
  EXPECT_EQ(contradicting_drive({{20, 10}, {0, 10}, {20, 2}}), 1U);
  EXPECT_EQ(contradicting_drive({{20, 10}, {10, 10}}), 2U) << "no drive";
  EXPECT_EQ(contradicting_drive({{0, 2}}), 1U) << "two false loops may be chance";
  EXPECT_EQ(contradicting_drive({{0, 5}, {0, 5}}), 1U) << "the later one of a draw";
  EXPECT_EQ(contradicting_drive({}), 0U);
}

}  // namespace
}  // namespace lidar_mapping::city::test
