// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/loop_closing/birds_eye_view.hpp"

#include "near.hpp"

namespace lidar_mapping::loop_closing {
namespace {

BirdsEyeView view_of(const std::vector<Eigen::Vector3f>& points) {
  return {points, std::vector<bool>(points.size(), true)};
}

/// Points of a place without order or symmetry, within 25 m.
std::vector<Eigen::Vector3f> place(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_int_distribution<int> cell(-25, 24);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 150; ++i) {
    const float x = 0.5F + static_cast<float>(cell(engine));
    points.emplace_back(x, 0.5F + static_cast<float>(cell(engine)), 2.0F);
  }
  return points;
}

std::vector<Eigen::Vector2f> moved(std::vector<Eigen::Vector2f> cells, float x, float y) {
  for (Eigen::Vector2f& cell : cells) cell += Eigen::Vector2f(x, y);
  return cells;
}

std::vector<Eigen::Vector2f> turned(std::vector<Eigen::Vector2f> cells, double yaw) {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
  for (Eigen::Vector2f& cell : cells) cell = R * cell;
  return cells;
}

TEST(BirdsEyeView, HasCellsOfOneMetreOnBothSidesOfZero) {
  const BirdsEyeView view =
      view_of({{0.1F, 0.1F, 0.0F}, {0.9F, 0.9F, 5.0F}, {-0.1F, 0.1F, 0.0F}, {7.2F, -3.7F, 1.0F}});
  EXPECT_EQ(view.count(), 3U) << "the first two are in one cell";
  EXPECT_EQ(view.cells(),
            (std::vector<Eigen::Vector2f>{{7.5F, -3.5F}, {-0.5F, 0.5F}, {0.5F, 0.5F}}));
}

TEST(BirdsEyeView, LeavesOutTheGroundAndWhatIsFarAway) {
  const std::vector<Eigen::Vector3f> points = {{1.0F, 1.0F, 0.0F},   {5.0F, 1.0F, 0.0F},
                                               {59.9F, 0.0F, 0.0F},  {60.0F, 0.0F, 0.0F},
                                               {45.0F, 45.0F, 0.0F}, {0.0F, -59.9F, 0.0F}};
  const BirdsEyeView view(points, {false, true, true, true, true, true});
  EXPECT_EQ(view.cells(),
            (std::vector<Eigen::Vector2f>{{0.5F, -59.5F}, {59.5F, 0.5F}, {5.5F, 1.5F}}));
  EXPECT_EQ(BirdsEyeView().count(), 0U);
  EXPECT_TRUE(view_of({}).cells().empty());
}

TEST(ViewCorrelator, FindsAnyShiftUpToFifteenMetres) {
  const BirdsEyeView target = view_of(place(1));
  const ViewCorrelator correlator(target);
  for (const float x : {-15.0F, -1.0F, 0.0F, 8.0F, 15.0F}) {
    for (const float y : {-15.0F, 0.0F, 3.0F, 15.0F}) {
      const ViewMatch match = correlator.match(moved(target.cells(), -x, -y), 0.0);
      EXPECT_EQ(match.translation, Eigen::Vector2d(x, y));
      EXPECT_NEAR(match.score, 1.0, 1e-9) << x << ", " << y;
    }
  }
  EXPECT_LT(correlator.match(moved(target.cells(), 16.0F, 0.0F), 0.0).score, 0.7);
}

TEST(ViewCorrelator, TurnsTheSourceFirst) {
  const BirdsEyeView target = view_of(place(2));
  const ViewCorrelator correlator(target);
  for (const double yaw : {0.5 * kPi, kPi, -0.5 * kPi}) {
    // The vehicle stood 4 m ahead and 2 m to the right, with this heading.
    const auto source = turned(moved(target.cells(), -4.0F, 2.0F), -yaw);
    const ViewMatch match = correlator.match(source, yaw);
    EXPECT_EQ(match.translation, Eigen::Vector2d(4.0, -2.0)) << yaw;
    EXPECT_GT(match.score, 0.9) << yaw;
    EXPECT_LT(correlator.match(source, yaw + 0.3).score, 0.8) << yaw;
  }
}

// A point near an edge of its cell also fits the next cell, but less well.
TEST(ViewCorrelator, GivesHalfTheWeightToTheNextCell) {
  const ViewCorrelator correlator(view_of({{0.5F, 0.5F, 0.0F}, {10.5F, 0.5F, 0.0F}}));
  const double exact = correlator.match({{0.5F, 0.5F}, {10.5F, 0.5F}}, 0.0).score;
  const double one_off = correlator.match({{0.5F, 0.5F}, {11.5F, 0.5F}}, 0.0).score;
  const double two_off = correlator.match({{0.5F, 0.5F}, {12.5F, 0.5F}}, 0.0).score;
  EXPECT_NEAR(exact, 1.0, 1e-9);
  EXPECT_NEAR(one_off, 0.75, 1e-9);
  EXPECT_NEAR(two_off, 0.5, 1e-9);
}

TEST(ViewCorrelator, CanScoreMoreThanOneWhereTheSourceHasTheNextCellsToo) {
  const ViewCorrelator correlator(view_of({{0.5F, 0.5F, 0.0F}}));
  std::vector<Eigen::Vector2f> block;
  for (const float x : {-0.5F, 0.5F, 1.5F}) {
    for (const float y : {-0.5F, 0.5F, 1.5F}) block.emplace_back(x, y);
  }
  EXPECT_NEAR(correlator.match(block, 0.0).score, 5.0 / 3.0, 1e-9);
}

TEST(ViewCorrelator, ScoresPartOfAPlaceLess) {
  const BirdsEyeView target = view_of(place(3));
  std::vector<Eigen::Vector2f> half = target.cells();
  half.resize(half.size() / 2);
  const ViewCorrelator correlator(target);
  EXPECT_NEAR(correlator.match(half, 0.0).score, std::sqrt(0.5), 0.01);
  EXPECT_LT(correlator.match(view_of(place(4)).cells(), 0.0).score, 0.5) << "another place";
  EXPECT_EQ(correlator.match({}, 0.0).score, 0.0);
}

TEST(ViewCorrelator, DoesNotDependOnTheOrderOfCells) {
  const ViewCorrelator correlator(view_of(place(5)));
  std::vector<Eigen::Vector2f> source = view_of(place(6)).cells();
  const ViewMatch before = correlator.match(source, 0.4);
  std::reverse(source.begin(), source.end());
  const ViewMatch after = correlator.match(source, 0.4);
  EXPECT_EQ(after.translation, before.translation);
  EXPECT_EQ(after.score, before.score);
}

// Cells at the ends of both views, shifted as far as they may be, stay within the grid.
TEST(ViewCorrelator, ReachesTheEndsOfTheView) {
  std::vector<Eigen::Vector3f> ring;
  for (int i = 0; i < 720; ++i) {
    const double angle = kPi * i / 360.0;
    ring.emplace_back(static_cast<float>(59.9 * std::cos(angle)),
                      static_cast<float>(59.9 * std::sin(angle)), 0.0F);
  }
  const BirdsEyeView view = view_of(ring);
  const ViewMatch match = ViewCorrelator(view).match(view.cells(), kPi / 4.0);
  EXPECT_GT(match.score, 0.3);
  EXPECT_LE(match.translation.cwiseAbs().maxCoeff(), 15.0);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing
