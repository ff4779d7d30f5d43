// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include <gtest/gtest.h>

#include "unclaimed_positions.hpp"

namespace lidar_mapping::ros_border {
namespace {

GnssPosition position_at(Stamp stamp) {
  GnssPosition position;
  position.stamp = stamp;
  return position;
}

std::vector<Stamp> stamps_of(const UnclaimedPositions& unclaimed) {
  std::vector<Stamp> stamps;
  for (const GnssPosition& position : unclaimed.positions()) stamps.push_back(position.stamp);
  return stamps;
}

TEST(UnclaimedPositions, AreThereForTheFirstKeyFrame) {
  UnclaimedPositions unclaimed;
  for (const Stamp stamp : {10, 20, 30}) unclaimed.add(position_at(stamp));
  EXPECT_EQ(stamps_of(unclaimed), (std::vector<Stamp>{10, 20, 30}));
}

TEST(UnclaimedPositions, GoWithTheKeyFrameOfTheirStamp) {
  UnclaimedPositions unclaimed;
  for (const Stamp stamp : {10, 20, 30}) unclaimed.add(position_at(stamp));
  unclaimed.drop_until(20);
  EXPECT_EQ(stamps_of(unclaimed), (std::vector<Stamp>{30})) << "it may belong to the next run";
}

// A recording that is played again.
TEST(UnclaimedPositions, MayGoBackInTime) {
  UnclaimedPositions unclaimed;
  for (const Stamp stamp : {90, 100, 10, 20}) unclaimed.add(position_at(stamp));
  unclaimed.drop_until(10);
  EXPECT_EQ(stamps_of(unclaimed), (std::vector<Stamp>{90, 100, 20}));
}

TEST(UnclaimedPositions, AreBoundedInNumber) {
  UnclaimedPositions unclaimed;
  constexpr auto kMost = static_cast<Stamp>(UnclaimedPositions::kMost);
  for (Stamp stamp = 0; stamp < kMost + 3; ++stamp) unclaimed.add(position_at(stamp));
  ASSERT_EQ(unclaimed.positions().size(), UnclaimedPositions::kMost);
  EXPECT_EQ(unclaimed.positions().front().stamp, 3);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
