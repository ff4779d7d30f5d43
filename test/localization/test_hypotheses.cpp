// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "hypotheses.hpp"
#include "near.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::near;

PoseEstimate at(double x) { return {planar(x, 0.0, 0.0), diagonal_covariance(0.1, 0.01)}; }

TEST(Hypotheses, AreOneForEachPlace) {
  Hypotheses hypotheses;
  hypotheses.verify(at(0.0));
  hypotheses.verify(at(100.0));
  hypotheses.begin_search();
  hypotheses.verify(at(0.5));
  ASSERT_EQ(hypotheses.size(), 2U);
  EXPECT_EQ(hypotheses.best()->verifications(), 2);
  EXPECT_NEAR(hypotheses.best()->estimate().T_map_base.translation.x(), 0.5, 1e-9);
}

// Two candidates of a search may end at the same place, which one scan alone has shown then.
TEST(Hypotheses, CountASearchOnceForEachPlace) {
  Hypotheses hypotheses;
  hypotheses.begin_search();
  hypotheses.verify(at(0.0));
  const double of_one_search = hypotheses.best()->log_odds();
  hypotheses.verify(at(0.5));
  EXPECT_EQ(hypotheses.best()->verifications(), 1);
  EXPECT_EQ(hypotheses.best()->log_odds(), of_one_search);
  hypotheses.begin_search();
  for (const double x : {0.5, 0.0, 100.0}) hypotheses.verify(at(x));
  EXPECT_EQ(hypotheses.best()->verifications(), 2);
  EXPECT_GT(hypotheses.best()->log_odds(), of_one_search);
}

TEST(Hypotheses, HaveProbabilitiesWithASumOfOne) {
  Hypotheses hypotheses;
  EXPECT_EQ(hypotheses.probability(), 0.0);
  EXPECT_EQ(hypotheses.best(), nullptr);
  hypotheses.verify(at(0.0));
  const double alone = hypotheses.probability();
  EXPECT_GT(alone, 0.8);
  EXPECT_LT(alone, 0.95);  // one verification is never certain
  hypotheses.verify(at(100.0));
  EXPECT_LT(hypotheses.probability(), 0.5);
}

TEST(Hypotheses, MoveWithOdometryAndBecomeLessCertain) {
  Hypotheses hypotheses;
  hypotheses.verify({planar(0.0, 0.0, 1.0), diagonal_covariance(0.1, 0.01)});
  const Pose motion = planar(2.0, 0.0, 0.2);
  hypotheses.move(motion, diagonal_covariance(0.05, 0.01));
  const PoseEstimate& moved = hypotheses.best()->estimate();
  EXPECT_TRUE(near(moved.T_map_base, planar(0.0, 0.0, 1.0) * motion, 1e-9));
  EXPECT_GT(moved.covariance(0, 0), 0.1 * 0.1 + 0.05 * 0.05);
}

TEST(Hypotheses, NearAClaimAreKept) {
  Hypotheses hypotheses;
  hypotheses.verify(at(0.0));
  hypotheses.verify(at(100.0));
  hypotheses.keep_near(planar(90.0, 0.0, 0.0), 20.0);
  ASSERT_EQ(hypotheses.size(), 1U);
  EXPECT_NEAR(hypotheses.best()->estimate().T_map_base.translation.x(), 100.0, 1e-9);
}

TEST(Hypothesis, LosesProbabilityToAPlaceThatExplainsMoreOfThePath) {
  Hypothesis left_the_map(at(0.0));
  int metres = 0;
  for (; left_the_map.is_possible() && metres < 100; ++metres) left_the_map.compare(0.7, 1.0);
  EXPECT_GT(metres, 5);  // a truck beside the vehicle hides as much
  EXPECT_LT(metres, 30);
  EXPECT_FALSE(left_the_map.is_refuted());  // it would begin anew if it were found again
  EXPECT_LT(left_the_map.log_odds(), 0.0);
  left_the_map.reduce_deficit(left_the_map.deficit());
  EXPECT_TRUE(left_the_map.is_possible());
}

TEST(Hypothesis, IsNotDistinguishedBySmallDifferencesNorByOneScanAtRest) {
  Hypothesis alike(at(0.0));
  for (int i = 0; i < 1000; ++i) alike.compare(0.14, 1.0);
  EXPECT_EQ(alike.deficit(), 0.0);
  alike.compare(0.7, 0.0);
  EXPECT_GT(alike.deficit(), 0.0);
  EXPECT_LT(alike.deficit(), 0.1);
}

double deficit_after(double best, double way) {
  Hypothesis place(at(0.0));
  place.compare(best, way);
  return place.deficit();
}

// The place itself agrees by nothing, so 0.5 are missing beyond the 0.15 that tell nothing.
TEST(Hypothesis, HasADeficitByTheDifferenceAndThePath) {
  EXPECT_NEAR(deficit_after(0.65, 1.0), 0.4 * 0.5, 1e-12);
  EXPECT_NEAR(deficit_after(0.65, 0.5), 0.2 * 0.5, 1e-12);
  EXPECT_NEAR(deficit_after(0.65, 0.0), 0.04 * 0.5, 1e-12)
      << "a scan at rest is a tenth of a metre";
  EXPECT_NEAR(deficit_after(0.65, 9.0), 0.4 * 0.5, 1e-12) << "one scan is no more than a metre";
  Hypothesis far_behind(at(0.0));
  for (int i = 0; i < 1000; ++i) far_behind.compare(1.0, 1.0);
  EXPECT_NEAR(far_behind.deficit(), 12.0, 1e-12) << "so that it can become the best one again";
}

TEST(Hypothesis, IsGivenUpAfterTenRefusals) {
  Hypothesis place(at(0.0));
  for (int i = 0; i < 9; ++i) place.refuse();
  EXPECT_FALSE(place.is_refuted());
  for (int i = 0; i < 2; ++i) place.refuse();
  EXPECT_TRUE(place.is_refuted());
}

TEST(Hypothesis, HasBoundedLogOdds) {
  Hypothesis right(at(0.0)), wrong(at(0.0));
  for (int i = 0; i < 100; ++i) right.verify(at(0.0));
  for (int i = 0; i < 100; ++i) wrong.refuse();
  EXPECT_NEAR(right.log_odds(), 7.0, 1e-12);
  EXPECT_NEAR(wrong.log_odds(), -3.0, 1e-12);
}

TEST(Hypothesis, BecomesLessCertainWithEachStepOfAPerfectOdometry) {
  Hypothesis place(at(0.0));
  for (int i = 0; i < 100; ++i) place.move(Pose::Identity(), Covariance6::Zero());
  const Covariance6& covariance = place.estimate().covariance;
  const double angle = 0.03 * kRadPerDeg;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(covariance(axis, axis), 0.1 * 0.1 + 100.0 * 0.01 * 0.01, 1e-9) << axis;
    EXPECT_NEAR(covariance(axis + 3, axis + 3), 0.01 * 0.01 + 100.0 * angle * angle, 1e-9) << axis;
  }
}

MapMatch match_with(double coverage, double agreement, bool converged = true,
                    std::size_t points = 500) {
  MapMatch match;
  match.converged = converged;
  match.agreement = {coverage, agreement, points};
  return match;
}

TEST(Evidence, FollowsFromTheMatch) {
  EXPECT_EQ(evidence_of(match_with(0.8, 0.6)), Evidence::kAgrees);
  EXPECT_EQ(evidence_of(match_with(0.8, 0.1)), Evidence::kContradicts);
  EXPECT_EQ(evidence_of(match_with(0.1, 0.9)), Evidence::kUnknown);
  EXPECT_EQ(evidence_of(match_with(0.8, 0.7, false)), Evidence::kContradicts);
  EXPECT_EQ(evidence_of(match_with(0.8, 0.7, true, 40)), Evidence::kUnknown);
}

TEST(Evidence, ChangesAtItsLimits) {
  EXPECT_EQ(evidence_of(match_with(0.41, 0.26)), Evidence::kAgrees);
  EXPECT_EQ(evidence_of(match_with(0.39, 0.26)), Evidence::kUnknown);
  EXPECT_EQ(evidence_of(match_with(0.41, 0.24)), Evidence::kUnknown);
  EXPECT_EQ(evidence_of(match_with(0.41, 0.16)), Evidence::kUnknown);
  EXPECT_EQ(evidence_of(match_with(0.41, 0.14)), Evidence::kContradicts);
  EXPECT_EQ(evidence_of(match_with(0.41, 0.26, true, 150)), Evidence::kAgrees);
  EXPECT_EQ(evidence_of(match_with(0.41, 0.26, true, 149)), Evidence::kUnknown);
}

}  // namespace
}  // namespace lidar_mapping::localization::test
