// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "local_map/moving_points.hpp"
#include "sampled_points.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionState;

constexpr float kStreetHalf = 10.0F;  // m, from the middle of the street to its facades
constexpr float kGround = -1.7F;      // m
constexpr float kTruckSide = 3.0F;    // m to the left

/// The side of a truck: the part of the plane y = kTruckSide between these x, m.
struct Truck {
  float from;
  float to;
};

/// What a sensor at (x, 0, 0), whose axes are those of the map, sees of a street along x: beams
/// every 0.4 degrees and rings every degree between -30 and 20 degrees of elevation, of which one
/// point per cube of half a metre is sampled.
SampledPoints scan_from(float x, const std::optional<Truck>& truck, float seconds = 0.0F) {
  PointCloud cloud;
  for (int column = 0; column < 900; ++column) {
    for (int row = -30; row <= 20; ++row) {
      const double azimuth = (column + 0.5) * kPi / 450.0;
      const double elevation = (row + 0.5) * kPi / 180.0;
      const Eigen::Vector3f d =
          Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                          std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
              .cast<float>();
      float range = kStreetHalf / std::abs(d.y());
      if (d.z() < 0.0F) range = std::min(range, kGround / d.z());
      if (truck && d.y() > 0.0F) {
        const float on_side = kTruckSide / d.y();
        const float along = x + on_side * d.x();
        if (on_side < range && along > truck->from && along < truck->to) range = on_side;
      }
      if (range > 60.0F) continue;
      cloud.points.push_back({range * d.x(), range * d.y(), range * d.z(), 0.0F});
      cloud.times.push_back(seconds);
    }
  }
  SamplingOptions options;
  options.resolution = 0.5;
  SampledPoints points;
  points.assign(cloud, ScanSampler(17).sample(cloud, options), 0.0);
  return points;
}

MotionState at(float x) {
  MotionState motion;
  motion.T_map_sensor.translation = {static_cast<double>(x), 0.0, 0.0};
  return motion;
}

bool is_on_truck(const SampledPoints& points, std::size_t i) {
  return std::abs(points.y[i] - kTruckSide) < 1e-3F && points.z[i] > kGround + 0.01F;
}

/// Fraction of the points on the truck, or of all others, that are marked: of these it may be the
/// ground below the side, which lies on its plane.
double marked_fraction(const SampledPoints& points, const PointMarks& marks, bool on_truck) {
  double marked = 0.0, all = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_on_truck(points, i) != on_truck) continue;
    all += 1.0;
    marked += marks.empty() ? 0.0 : marks[i];
  }
  return marked / all;
}

// The truck is there from the first scan on, and nothing tells it from a wall before it has moved.
TEST(MovingPoints, AreFoundOfATruckThatDrivesAlongside) {
  MovingPointFinder finder;
  const SampledPoints beginning = scan_from(0.0F, Truck{-9.0F, 9.0F});
  EXPECT_TRUE(finder.find(beginning, at(0.0F)).empty()) << "without a view";
  finder.add_view(beginning, at(0.0F));
  EXPECT_TRUE(finder.find(beginning, at(0.0F)).empty());
  for (const float x : {5.0F, 10.0F, 20.0F}) {
    const SampledPoints scan = scan_from(x, Truck{x - 9.0F, x + 9.0F});
    const PointMarks marks = finder.find(scan, at(x));
    EXPECT_GT(marked_fraction(scan, marks, true), 0.99) << x;
    EXPECT_LT(marked_fraction(scan, marks, false), 0.03) << x;
    finder.add_view(scan, at(x));
  }
}

TEST(MovingPoints, AreNoneInAStreetThatStandsStill) {
  MovingPointFinder finder;
  for (float x = 0.0F; x < 60.0F; x += 2.0F) {
    const SampledPoints scan = scan_from(x, Truck{12.0F, 30.0F});
    EXPECT_TRUE(finder.find(scan, at(x)).empty()) << x;
    finder.add_view(scan, at(x));
  }
}

TEST(MovingPoints, AreNoneWhereNoViewReaches) {
  MovingPointFinder finder;
  finder.add_view(scan_from(0.0F, std::nullopt), at(0.0F));
  EXPECT_FALSE(finder.find(scan_from(15.0F, Truck{6.0F, 24.0F}), at(15.0F)).empty());
  EXPECT_TRUE(finder.find(scan_from(40.0F, Truck{31.0F, 49.0F}), at(40.0F)).empty()) << "too far";
  finder.clear();
  EXPECT_TRUE(finder.find(scan_from(15.0F, Truck{6.0F, 24.0F}), at(15.0F)).empty());
}

// Where the sensor stands, a view would only be of the same place as the last one.
TEST(MovingPoints, AreSeenFromTheLastTwentyFiveMetres) {
  MovingPointFinder finder;
  finder.add_view(scan_from(0.0F, std::nullopt), at(0.0F));
  for (int i = 0; i < 10; ++i)
    finder.add_view(scan_from(4.0F, Truck{0.0F, 20.0F}), at(4.0F));  // too near: not kept
  const SampledPoints scan = scan_from(10.0F, Truck{0.0F, 20.0F});
  EXPECT_FALSE(finder.find(scan, at(10.0F)).empty()) << "the free street is remembered";
  for (float x = 10.0F; x <= 30.0F; x += 5.0F)
    finder.add_view(scan_from(x, Truck{0.0F, 20.0F}), at(x));
  EXPECT_TRUE(finder.find(scan, at(10.0F)).empty()) << "the view of the free street was the sixth";
}

// Robust weights suffice for what is small.
TEST(MovingPoints, AreNotWorthMentioningOfACar) {
  MovingPointFinder finder;
  finder.add_view(scan_from(0.0F, std::nullopt), at(0.0F));
  EXPECT_TRUE(finder.find(scan_from(15.0F, Truck{12.0F, 15.0F}), at(15.0F)).empty());
}

// Points are compared where they were when they were measured.
TEST(MovingPoints, AreDeskewed) {
  MovingPointFinder finder;
  finder.add_view(scan_from(0.0F, std::nullopt), at(0.0F));
  const SampledPoints scan = scan_from(10.0F, Truck{1.0F, 19.0F}, 0.05F);
  MotionState motion = at(9.0F);
  motion.twist[0] = 20.0;  // m/s: 1 m in 0.05 s
  const PointMarks marks = finder.find(scan, motion);
  EXPECT_GT(marked_fraction(scan, marks, true), 0.99);
  EXPECT_LT(marked_fraction(scan, marks, false), 0.03);
}

TEST(SampledPoints, KeepTheOrderOfThoseThatAreNotRemoved) {
  SampledPoints points = sampled({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, 0.5F);
  points.s[2] = 0.7F;
  points.remove({0, 1, 0});
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points.position(0), Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(points.position(1), Eigen::Vector3f(7, 8, 9));
  EXPECT_EQ(points.s, (std::vector<float>{0.5F, 0.7F}));
  points.remove({1, 1});
  EXPECT_EQ(points.size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::front_end
