// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "near.hpp"
#include "pass_registration.hpp"

namespace lidar_mapping::map_quality {
namespace {

constexpr double kNoise = 0.01;  // m

/// Which surfaces of a street a pass observed.
struct Surfaces {
  bool ground = true;
  bool fronts = true;  ///< the walls on both sides
  bool gables = true;  ///< walls across the street
};

/// Random points on a street of 30 m by 16 m around the LiDAR, each with its ray.
ObservedPoints street(unsigned seed, const Surfaces& surfaces = {}, int count = 20'000) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, kNoise);
  ObservedPoints points;
  for (int i = 0; i < count; ++i) {
    const double a = unit(engine), b = unit(engine);
    const double x = 30.0 * a - 15.0;
    Eigen::Vector3d p;
    if (i % 4 <= 1) {
      if (!surfaces.ground) continue;
      p = {x, 16.0 * b - 8.0, -1.8};
    } else if (i % 4 == 2) {
      if (!surfaces.fronts) continue;
      p = {x, i % 8 == 2 ? 7.3 : -7.4, 6.0 * b - 1.8};
    } else {
      if (!surfaces.gables) continue;
      p = {i % 8 == 3 ? 9.3 : -10.4, 14.0 * a - 7.0, 6.0 * b - 1.8};
    }
    p += noise(engine) * p.normalized();
    points.push_back({p, p});
  }
  return points;
}

/// The points of a pass that is displaced by this translation and turned about the centre.
ObservedPoints displaced(ObservedPoints points, const Shift& shift) {
  const Eigen::AngleAxisd turn(shift[3], Eigen::Vector3d::UnitZ());
  for (ObservedPoint& point : points) {
    point.position = turn * point.position + shift.head<3>();
    point.beam = turn * point.beam;
  }
  return points;
}

Shift shift_of(double x, double y, double z, double yaw = 0.0) { return {x, y, z, yaw}; }

TEST(RegisterPasses, FindsTranslationAndTurn) {
  const ObservedPoints earlier = street(1);
  for (const Shift& truth :
       {shift_of(0.0, 0.0, 0.0), shift_of(0.05, -0.03, 0.02), shift_of(-0.3, 0.2, 0.1),
        shift_of(0.0, 0.1, 0.0, 0.005), shift_of(0.4, 0.0, -0.2, -0.01)}) {
    const PassShift found = register_passes(earlier, displaced(street(2), truth), true);
    ASSERT_TRUE(found.is_known());
    EXPECT_TRUE(test::near(found.shift.head<3>(), truth.head<3>(), 0.01)) << truth.transpose();
    EXPECT_NEAR(found.shift[3], truth[3], 0.0007) << truth.transpose();
    EXPECT_LT(found.residual, kNoise) << truth.transpose();
    EXPECT_GT(found.agreeing_walls, 30U) << truth.transpose();
  }
}

// Further than cells of 1 m reach.
TEST(RegisterPasses, FindsMoreThanHalfAMetre) {
  const Shift truth = shift_of(0.6, -0.5, 0.7);
  const PassShift found = register_passes(street(1), displaced(street(2), truth), true);
  ASSERT_TRUE(found.is_known());
  EXPECT_TRUE(test::near(found.shift.head<3>(), truth.head<3>(), 0.02));
}

TEST(RegisterPasses, GivesTheOppositeIfThePassesAreExchanged) {
  const ObservedPoints a = street(1);
  const ObservedPoints b = displaced(street(2), shift_of(0.1, 0.2, -0.05, 0.003));
  const Shift forward = register_passes(a, b, true).shift;
  const Shift backward = register_passes(b, a, true).shift;
  EXPECT_TRUE(test::near(backward.head<3>(), -forward.head<3>(), 0.01));
  EXPECT_NEAR(backward[3], -forward[3], 0.0007);
}

TEST(RegisterPasses, DoesNotDependOnTheOrderOfThePoints) {
  ObservedPoints earlier = street(1);
  ObservedPoints later = displaced(street(2), shift_of(0.1, 0.2, -0.05, 0.003));
  const PassShift before = register_passes(earlier, later, true);
  std::reverse(earlier.begin(), earlier.end());
  std::reverse(later.begin(), later.end());
  const PassShift after = register_passes(earlier, later, true);
  EXPECT_TRUE(test::near(after.shift, before.shift, 1e-6));
  EXPECT_EQ(after.planes, before.planes);
}

// Ground alone says nothing about where along the road one is.
TEST(RegisterPasses, LeavesDirectionsAloneThatNoPlaneConstrains) {
  const Surfaces ground_only{true, false, false};
  const Shift truth = shift_of(0.2, 0.1, 0.05);
  const PassShift found =
      register_passes(street(1, ground_only), displaced(street(2, ground_only), truth), true);
  ASSERT_TRUE(found.is_known());
  EXPECT_TRUE(test::near(found.shift, shift_of(0.0, 0.0, 0.05), 0.01));
  EXPECT_EQ(found.agreeing_walls, 0U);
  // Between two walls the way along them stays unknown, and nothing else.
  const Surfaces corridor{true, true, false};
  const PassShift along =
      register_passes(street(1, corridor), displaced(street(2, corridor), truth), true);
  ASSERT_TRUE(along.is_known());
  EXPECT_TRUE(test::near(along.shift.head<3>(), Eigen::Vector3d(0.0, 0.1, 0.05), 0.01));
}

TEST(RegisterPasses, IsUnknownWithFewPlanes) {
  EXPECT_FALSE(register_passes({}, {}, true).is_known());
  EXPECT_FALSE(register_passes(street(1), {}, true).is_known());
  EXPECT_FALSE(register_passes({}, street(1), true).is_known());
  EXPECT_FALSE(register_passes(street(1), street(2, {}, 100), true).is_known());
  const ObservedPoints elsewhere = displaced(street(2), shift_of(500.0, 0.0, 0.0));
  EXPECT_FALSE(register_passes(street(1), elsewhere, true).is_known());
}

/// A floor of 20 m by 20 m at this height, observed from `beam`, between walls.
ObservedPoints storey(unsigned seed, double floor, const Eigen::Vector3d& beam) {
  ObservedPoints points = street(seed, {false, true, true});
  std::mt19937 engine(seed + 100);
  std::uniform_real_distribution<double> place(-7.0, 7.0);
  for (int i = 0; i < 20'000; ++i) {
    const double x = place(engine);
    points.push_back({{x, place(engine), floor}, beam});
  }
  return points;
}

// The floor of a car park is the ceiling of the storey below, 15 cm lower.
TEST(RegisterPasses, MatchesSurfacesSeenFromTheSameSideOnly) {
  const ObservedPoints above = storey(1, 0.45, {0.0, 0.0, -1.0});
  const ObservedPoints below = storey(2, 0.3, {0.0, 0.0, 1.0});
  const PassShift sided = register_passes(above, below, true);
  const PassShift unsided = register_passes(above, below, false);
  ASSERT_TRUE(sided.is_known());
  ASSERT_TRUE(unsided.is_known());
  EXPECT_NEAR(sided.shift[2], 0.0, 0.01) << "nothing tells the height";
  EXPECT_NEAR(unsided.shift[2], -0.15, 0.01);
  EXPECT_LT(sided.planes, unsided.planes);
}

TEST(RegisterPasses, IsNotLedAstrayByParkedCars) {
  const Shift truth = shift_of(0.05, 0.1, -0.03);
  ObservedPoints earlier = street(1), later = street(2);
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> x(-12.0, 12.0), z(-1.5, -0.3);
  // A row of cars along the kerb, half a metre further out when the street was passed again.
  for (int i = 0; i < 4'000; ++i) {
    for (const bool again : {false, true}) {
      const double along = x(engine);
      const Eigen::Vector3d p(along, again ? 4.9 : 4.4, z(engine));
      (again ? later : earlier).push_back({p, p});
    }
  }
  const PassShift found = register_passes(earlier, displaced(later, truth), true);
  EXPECT_TRUE(test::near(found.shift.head<3>(), truth.head<3>(), 0.015));
}

}  // namespace
}  // namespace lidar_mapping::map_quality
