// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "visits/point_history.hpp"

namespace lidar_mapping::moving_objects {
namespace {

constexpr std::uint32_t kOwn = 3;

/// The history of one point: visits with what they have observed, '1' something, '0' nothing, '-'
/// that they did not look there. The own visit is the fourth one.
PointHistory history(const std::string& observed) {
  PointHistory result(kOwn, 1);
  for (std::uint32_t visit = 0; visit < observed.size(); ++visit) {
    if (visit == kOwn) continue;
    const char seen = observed[visit];
    const Vote vote = seen == '1' ? Vote::kStatic : seen == '0' ? Vote::kMoving : Vote::kUnseen;
    result.add(visit, {vote}, seen == '0' ? Marks{0} : Marks{});
  }
  return result;
}

TEST(PointHistory, GivesTheVisitsBetweenWhichAPointDisappeared) {
  EXPECT_FALSE(history("---1---").disappeared(0));
  EXPECT_FALSE(history("---1111").disappeared(0));
  EXPECT_FALSE(history("0001---").disappeared(0)) << "what was before does not matter";
  const auto gone = history("---11-0").disappeared(0);
  ASSERT_TRUE(gone);
  EXPECT_EQ(gone->kind, ChangeKind::kDisappeared);
  EXPECT_EQ(gone->present, 4U);
  EXPECT_EQ(gone->absent, 6U);
  EXPECT_EQ(history("---1000").disappeared(0)->absent, 4U) << "the first visit without it";
  EXPECT_FALSE(history("---1001").disappeared(0)) << "it came back";
}

TEST(PointHistory, GivesTheVisitsBetweenWhichAPointAppeared) {
  EXPECT_FALSE(history("---1000").appeared(0)) << "what was after does not matter";
  EXPECT_FALSE(history("1111").appeared(0));
  const auto came = history("00-1").appeared(0);
  ASSERT_TRUE(came);
  EXPECT_EQ(came->kind, ChangeKind::kAppeared);
  EXPECT_EQ(came->absent, 1U);
  EXPECT_EQ(came->present, kOwn);
  EXPECT_EQ(history("0111").appeared(0)->absent, 0U);
  EXPECT_EQ(history("0111").appeared(0)->present, 1U) << "the first visit with it";
}

TEST(PointHistory, UsesTheDecisionOfTheNeighbourhood) {
  PointHistory decided(kOwn, 2);
  decided.add(4, {Vote::kStatic, Vote::kMoving}, {0});
  EXPECT_TRUE(decided.disappeared(0));
  EXPECT_FALSE(decided.disappeared(1)) << "a vote alone is no decision";
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
