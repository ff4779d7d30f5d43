// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"

namespace lidar_mapping::loop_closing {
namespace {

using Cells = std::vector<Eigen::Vector2f>;

/// House fronts at random places and in a few directions, within 45 m, as points every metre.
Cells town(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> place(-30.0F, 30.0F), turn(0.0F, 3.1F);
  std::uniform_int_distribution<int> length(5, 14);
  Cells cells;
  for (int front = 0; front < 12; ++front) {
    const float x = place(engine), y = place(engine), angle = turn(engine);
    const Eigen::Vector2f along(std::cos(angle), std::sin(angle));
    const int count = length(engine);
    for (int i = 0; i < count; ++i) {
      cells.push_back(Eigen::Vector2f(x, y) + static_cast<float>(i) * along);
    }
  }
  return cells;
}

/// The cells as a vehicle sees them from `p` with this heading.
Cells seen_from(Cells cells, const Eigen::Vector2f& p, double heading) {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(-heading)).toRotationMatrix();
  for (Eigen::Vector2f& cell : cells) cell = R * (cell - p);
  return cells;
}

/// Difference of headings that are known up to half a turn.
double modulo_pi(double angle) { return std::abs(std::remainder(angle, kPi)); }

TEST(SpectrumDescriptor, GivesTheHeadingOfAnotherVisit) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const SpectrumDescriptor here(town(seed));
    for (const double heading : {0.0, 0.31, 1.0, kPi / 2.0, 3.0, -0.7}) {
      const SpectrumDescriptor there(seen_from(town(seed), {1.5F, -2.0F}, heading));
      const auto comparison = here.compare(there);
      EXPECT_LT(modulo_pi(comparison.yaw - heading), 0.03) << seed << ", " << heading;
      EXPECT_GE(comparison.yaw, 0.0);
      EXPECT_LT(comparison.yaw, kPi + 1e-9);
      EXPECT_GT(comparison.similarity, 0.8) << seed << ", " << heading;
    }
  }
}

TEST(SpectrumDescriptor, IsMostSimilarToItself) {
  const SpectrumDescriptor own(town(1));
  const auto comparison = own.compare(own);
  EXPECT_NEAR(comparison.similarity, 1.0, 2e-3) << "of numbers of half precision";
  EXPECT_LT(modulo_pi(comparison.yaw), 1e-3);
  for (const unsigned seed : {2U, 3U, 4U, 5U}) {
    EXPECT_LT(own.compare(SpectrumDescriptor(town(seed))).similarity, 0.8) << seed;
  }
}

TEST(SpectrumDescriptor, ComparesInBothDirections) {
  const SpectrumDescriptor a(town(1)), b(seen_from(town(1), {3.0F, 2.0F}, 0.8)), c(town(2));
  EXPECT_LT(modulo_pi(a.compare(b).yaw + b.compare(a).yaw), 0.01);
  EXPECT_NEAR(a.compare(b).similarity, b.compare(a).similarity, 1e-5);
  EXPECT_NEAR(a.compare(c).similarity, c.compare(a).similarity, 1e-5);
}

// The magnitude of a spectrum does not change with a shift, but for what leaves the view.
TEST(SpectrumDescriptor, HardlyDependsOnThePosition) {
  const SpectrumDescriptor here(town(1));
  double least = 1.0;
  for (const float x : {-10.0F, -2.5F, 0.4F, 5.0F}) {
    const auto comparison = here.compare(SpectrumDescriptor(seen_from(town(1), {x, 3.0F}, 0.0)));
    least = std::min(least, comparison.similarity);
    EXPECT_LT(modulo_pi(comparison.yaw), 0.02) << x;
  }
  EXPECT_GT(least, 0.9);
}

TEST(SpectrumKey, DoesNotChangeWithTheHeading) {
  const auto key = SpectrumDescriptor(town(1)).key();
  const auto elsewhere = SpectrumDescriptor(town(2)).key();
  const float other = (key - elsewhere).norm();
  for (const int steps : {1, 7, 20, 33}) {
    const double heading = steps * kPi / SpectrumDescriptor::kDirections;
    const auto turned = SpectrumDescriptor(seen_from(town(1), {0.0F, 0.0F}, heading)).key();
    EXPECT_LT((key - turned).norm(), 0.05F * other) << steps << " whole directions";
  }
  const auto oblique = SpectrumDescriptor(seen_from(town(1), {2.0F, 1.0F}, 0.426)).key();
  EXPECT_LT((key - oblique).norm(), 0.4F * other);
}

TEST(SpectrumDescriptor, OfNothingIsSimilarToNothing) {
  const SpectrumDescriptor none, empty{Cells()}, place(town(1));
  EXPECT_EQ(none.compare(place).similarity, 0.0);
  EXPECT_EQ(place.compare(empty).similarity, 0.0);
  EXPECT_TRUE(empty.key().isZero(0.0F));
}

// Cells at the ends of the view, or a single one, are no special case.
TEST(SpectrumDescriptor, HasNumbersForFewAndFarCells) {
  for (const Cells& cells :
       {Cells{{0.5F, 0.5F}}, Cells{{59.5F, 0.5F}, {-59.5F, -0.5F}, {0.5F, 59.5F}, {-0.5F, -59.5F}},
        Cells(500, {42.0F, -42.0F})}) {
    const SpectrumDescriptor descriptor(cells);
    EXPECT_TRUE(descriptor.key().allFinite());
    const auto comparison = descriptor.compare(descriptor);
    EXPECT_LE(comparison.similarity, 1.01);
    EXPECT_TRUE(std::isfinite(comparison.yaw));
  }
}

// A room with four equal walls looks the same after a quarter of a turn, not after an eighth.
TEST(SpectrumDescriptor, FollowsTheSymmetryOfThePlace) {
  Cells square;
  for (int i = -15; i <= 15; ++i) {
    const auto at = static_cast<float>(i);
    for (const float side : {-15.0F, 15.0F}) {
      square.emplace_back(at, side);
      square.emplace_back(side, at);
    }
  }
  const SpectrumDescriptor straight(square);
  const SpectrumDescriptor quarter(seen_from(square, {0.0F, 0.0F}, 0.5 * kPi));
  const SpectrumDescriptor eighth(seen_from(square, {0.0F, 0.0F}, 0.25 * kPi));
  EXPECT_NEAR(straight.compare(quarter).similarity, 1.0, 0.01);
  const double yaw = straight.compare(eighth).yaw;
  EXPECT_LT(std::abs(std::remainder(yaw - 0.25 * kPi, 0.5 * kPi)), 0.02) << yaw;
}

}  // namespace
}  // namespace lidar_mapping::loop_closing
