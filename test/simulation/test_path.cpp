// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "motion/path.hpp"
#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

using test::near;

/// Along x, and on to the left.
Path bend(double radius) { return Path::rounded({{0.0, 0.0}, {50.0, 0.0}, {50.0, 50.0}}, radius); }

std::vector<Eigen::Vector2d> circle(double radius) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 500; ++i) {
    const double angle = Path::kSpacing * i / radius;
    points.push_back(radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

TEST(Path, IsALineBetweenTwoCorners) {
  const Path path = Path::rounded({{1.0, 2.0}, {4.0, 6.0}}, 5.0);
  EXPECT_NEAR(path.length(), 5.0, Path::kSpacing);
  for (const double station : {1.0, 2.5, 3.33}) {
    EXPECT_TRUE(near(path.position(station),
                     Eigen::Vector2d(1.0 + 0.6 * station, 2.0 + 0.8 * station), 1e-9));
    EXPECT_NEAR(path.heading(station), std::atan2(0.8, 0.6), 1e-9);
    EXPECT_NEAR(path.curvature(station), 0.0, 1e-9);
  }
}

TEST(Path, FollowsACircle) {
  constexpr double kRadius = 20.0;
  const Path path(circle(kRadius));
  for (const double station : {5.0, 12.34, 40.0}) {
    const double angle = station / kRadius;
    EXPECT_TRUE(near(path.position(station),
                     kRadius * Eigen::Vector2d(std::cos(angle), std::sin(angle)), 1e-5));
    EXPECT_NEAR(path.heading(station), angle + 0.5 * kPi, 1e-4);
    EXPECT_NEAR(path.curvature(station), 1.0 / kRadius, 1e-4);
  }
}

/// The heading does not jump by a turn.
TEST(Path, UnwrapsItsHeading) {
  std::vector<Eigen::Vector2d> points = circle(5.0);  // 50 m are 1.6 rounds
  const Path path(std::move(points));
  EXPECT_NEAR(path.heading(45.0) - path.heading(5.0), 8.0, 1e-2);
}

TEST(Path, RoundsACornerWithItsRadius) {
  constexpr double kRadius = 10.0;
  const Path path = bend(kRadius);
  EXPECT_NEAR(path.length(), 100.0 - 2.0 * kRadius + 0.5 * kPi * kRadius, 0.3);
  double greatest = 0.0;
  for (double s = 1.0; s < path.length() - 1.0; s += 0.25) {
    greatest = std::max(greatest, std::abs(path.curvature(s)));
  }
  EXPECT_NEAR(greatest, 1.0 / kRadius, 0.02 / kRadius);
  EXPECT_NEAR(path.heading(path.length() - 5.0), 0.5 * kPi, 1e-3);
  EXPECT_GT(path.curvature(path.length() / 2.0), 0.0) << "to the left";
}

/// Blending spreads the change of the curvature, which else were a step.
TEST(Path, HasAContinuousCurvature) {
  const Path path = bend(10.0);
  for (double s = 1.0; s < path.length() - 1.0; s += 0.1) {
    EXPECT_LT(std::abs(path.curvature(s + 0.1) - path.curvature(s)), 0.012) << s;
  }
}

/// A corner between short legs gets a smaller radius, so that its arc fits in.
TEST(Path, FitsArcsBetweenShortLegs) {
  const Path path = Path::rounded({{0.0, 0.0}, {8.0, 0.0}, {8.0, 8.0}}, 50.0);
  EXPECT_LT(path.length(), 16.0) << "shorter than its legs";
  EXPECT_TRUE(near(path.position(0.0), Eigen::Vector2d(0.0, 0.0), 0.2));
  EXPECT_TRUE(near(path.position(path.length()), Eigen::Vector2d(8.0, 8.0), 0.3));
}

TEST(Path, WeavesAboutItsLine) {
  const Path line = Path::rounded({{0.0, 0.0}, {400.0, 0.0}}, 5.0);
  const Path weaving = line.weaving(0.5, 1.0);
  double left = 0.0, right = 0.0;
  for (double s = 0.0; s < weaving.length(); s += 1.0) {
    left = std::max(left, weaving.position(s).y());
    right = std::min(right, weaving.position(s).y());
    EXPECT_NEAR(weaving.position(s).x(), s, 1e-6);
  }
  EXPECT_LE(left, 0.5);
  EXPECT_GE(right, -0.5);
  EXPECT_GT(left - right, 0.5);
  EXPECT_GT((weaving.position(100.0) - line.weaving(0.5, 2.0).position(100.0)).norm(), 0.01)
      << "another phase is another path";
}

TEST(Path, EndsWhereItEnds) {
  const Path path = Path::rounded({{0.0, 0.0}, {10.0, 0.0}}, 5.0);
  EXPECT_EQ(path.position(-5.0), path.position(0.0));
  EXPECT_EQ(path.position(path.length() + 5.0), path.position(path.length()));
}

}  // namespace
}  // namespace lidar_mapping::simulation
