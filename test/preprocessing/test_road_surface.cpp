// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "floor/road_surface.hpp"
#include "near.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr double kTolerance = 0.2;  // m

/// A road 30 m long and 8 m wide below the vehicle: its rise along x and y, and the radius of its
/// crest (m; infinity: even).
struct Road {
  double height = -1.7;
  double rise_x = 0.0;
  double rise_y = 0.0;
  double radius = std::numeric_limits<double>::infinity();

  double at(double x, double y) const {
    return height + rise_x * x + rise_y * y - 0.5 * x * x / radius;
  }
  Points points(unsigned seed, int count = 2000, double noise = 0.01, double length = 30.0) const {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> unit(-0.5, 0.5);
    std::normal_distribution<double> error(0.0, noise);
    Points result;
    for (int i = 0; i < count; ++i) {
      const double x = length * unit(engine), y = 8.0 * unit(engine);
      result.emplace_back(x, y, at(x, y) + error(engine));
    }
    return result;
  }
};

/// A level plane at this height.
Plane level(double z) { return {Eigen::Vector3d::UnitZ(), -z}; }

TEST(RoadSurface, IsZeroOnItself) {
  // It rises by 0.02 to the front and 0.05 to the left, in a dip.
  const RoadSurface surface(Eigen::Vector4d(0.05, -0.02, -1.7, 0.01));
  EXPECT_NEAR(surface.above({0.0, 0.0, -1.7}), 0.0, 1e-12);
  EXPECT_NEAR(surface.above({0.0, 2.0, -1.6}), 0.0, 1e-12);
  EXPECT_NEAR(surface.above({10.0, 0.0, -1.7 + 0.2 + 0.5}), 0.0, 1e-12);
  EXPECT_NEAR(surface.above({-10.0, 0.0, -1.7 - 0.2 + 0.5}), 0.0, 1e-12);
  EXPECT_NEAR(surface.above({0.0, 0.0, 0.0}), 1.7, 1e-12);
  EXPECT_EQ(surface.curvature(), 0.01);
}

TEST(RoadSurface, HasTheTangentThatItWasMadeOf) {
  const Plane plane{Eigen::Vector3d(0.1, -0.2, 1.0).normalized(), 1.6};
  const RoadSurface surface(plane);
  const Plane tangent = surface.tangent();
  EXPECT_TRUE(test::near(tangent.normal, plane.normal, 1e-12));
  EXPECT_NEAR(tangent.offset, plane.offset, 1e-12);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(3.0, 0.0), Eigen::Vector2d(-4.0, 7.0)}) {
    const double z = -surface.above({p.x(), p.y(), 0.0});
    EXPECT_NEAR(plane.distance({p.x(), p.y(), z}), 0.0, 1e-12);
  }
}

TEST(FitRoad, FindsAnEvenRoad) {
  for (const auto& [rise_x, rise_y] :
       {std::pair(0.0, 0.0), std::pair(0.04, 0.0), std::pair(-0.03, 0.02)}) {
    Road road;
    road.rise_x = rise_x;
    road.rise_y = rise_y;
    // The start is off by 5 cm and a degree.
    Plane start = RoadSurface(Eigen::Vector4d(rise_y, -rise_x + 0.005, -1.65, 0.0)).tangent();
    const auto fit = fit_road(road.points(1), start, kTolerance);
    ASSERT_TRUE(fit.has_value());
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(12.0, 3.0)}) {
      EXPECT_NEAR(fit->surface.above({p.x(), p.y(), road.at(p.x(), p.y())}), 0.0, 0.005);
    }
    EXPECT_LT(std::abs(fit->surface.curvature()), 1e-4);
    EXPECT_EQ(fit->inliers.size(), 2000U);
  }
}

// On a crest a plane would lie too low below the vehicle.
TEST(FitRoad, FollowsACrestAndADip) {
  for (const double radius : {300.0, -300.0, 600.0}) {
    Road road;
    road.radius = radius;
    const auto fit = fit_road(road.points(2), level(-1.7), kTolerance);
    ASSERT_TRUE(fit.has_value());
    EXPECT_NEAR(fit->surface.curvature(), -1.0 / radius, 2e-4) << radius;
    EXPECT_NEAR(fit->surface.above({0.0, 0.0, -1.7}), 0.0, 0.005) << radius;
    EXPECT_NEAR(fit->surface.tangent().offset, 1.7, 0.005) << radius;
  }
}

TEST(FitRoad, LeavesOutWhatStandsOnTheRoad) {
  const Road road;
  Points points = road.points(3);
  for (const Eigen::Vector3d& p : road.points(4, 800)) {
    points.emplace_back(p.x(), 0.3 * p.y() + 2.0, p.z() + 0.5);
  }
  points.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0.0, -1.7);
  const auto fit = fit_road(points, level(-1.7), kTolerance);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->surface.above({0.0, 0.0, -1.7}), 0.0, 0.003);
  EXPECT_TRUE(test::near(fit->surface.tangent().normal, Eigen::Vector3d::UnitZ(), 0.001));
  ASSERT_EQ(fit->inliers.size(), 2000U);
  EXPECT_EQ(fit->inliers.back(), 1999U) << "the numbers of the points of the road";
}

// A pavement 12 cm above the road, all along its right side.
TEST(FitRoad, IsNotLiftedByAPavement) {
  const Road road;
  Points points = road.points(3);
  for (const Eigen::Vector3d& p : road.points(4, 400)) {
    points.emplace_back(p.x(), 0.2 * p.y() - 4.8, p.z() + 0.12);
  }
  const auto fit = fit_road(points, level(-1.7), kTolerance);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->surface.above({0.0, 0.0, -1.7}), 0.0, 0.01);
}

TEST(FitRoad, NeedsAnArea) {
  EXPECT_FALSE(fit_road({}, level(-1.7), kTolerance).has_value());
  EXPECT_FALSE(fit_road({{1.0, 2.0, -1.7}}, level(-1.7), kTolerance).has_value());
  Points line;
  for (int i = 0; i < 100; ++i) line.emplace_back(0.1 * i, 0.05 * i, -1.7);
  EXPECT_FALSE(fit_road(line, level(-1.7), kTolerance).has_value());
  EXPECT_FALSE(fit_road(Road().points(1), level(0.0), kTolerance).has_value())
      << "no point is near the start";
}

TEST(FitRoad, DoesNotDependOnTheOrderOfThePoints) {
  Points points = Road().points(5);
  const auto forward = fit_road(points, level(-1.7), kTolerance);
  std::reverse(points.begin(), points.end());
  const auto backward = fit_road(points, level(-1.7), kTolerance);
  ASSERT_TRUE(forward && backward);
  EXPECT_TRUE(
      test::near(forward->surface.tangent().normal, backward->surface.tangent().normal, 1e-9));
  EXPECT_TRUE(test::near(forward->covariance, backward->covariance, 1e-12));
}

// Points that lie close together share their error, so more of them tell nothing new.
TEST(FitRoadCovariance, CountsPatchesInsteadOfPoints) {
  const auto covariance = [](int count, double length) {
    return fit_road(Road().points(6, count, 0.03, length), level(-1.7), kTolerance)
        .value()
        .covariance;
  };
  const Eigen::Matrix3d few = covariance(2000, 30.0), many = covariance(8000, 30.0);
  EXPECT_TRUE(
      test::near(many.diagonal().cwiseQuotient(few.diagonal()), Eigen::Vector3d::Ones(), 0.3));
  const Eigen::Matrix3d small = covariance(2000, 8.0);
  EXPECT_GT(small(1, 1), 3.0 * few(1, 1)) << "a short piece tells less about the slope along it";
}

TEST(FitRoadCovariance, HasALowerBound) {
  const auto fit = fit_road(Road().points(7, 20'000, 0.0), level(-1.7), kTolerance);
  ASSERT_TRUE(fit.has_value());
  EXPECT_GE(std::sqrt(fit->covariance(2, 2)), 0.01) << "no road is even to the millimetre";
  EXPECT_GE(std::sqrt(fit->covariance(0, 0)), 0.001);
  EXPECT_GE(std::sqrt(fit->covariance(1, 1)), 0.001);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
