// SPDX-License-Identifier: BSD-3-Clause
// Surfaces between the rings of a scan.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "scan/ring_interpolator.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kHeight = 1.8;  // m, of the sensor above the ground
const Eigen::Vector3d kSensor(0.8, 0.0, kHeight);

/// What a sensor with 16 rings at kSensor sees: flat ground, or what is in the way after range().
template <typename Range>
PointCloud seen(Range&& range) {
  PointCloud cloud;
  for (int column = 0; column < 1800; ++column) {
    const double azimuth = 2.0 * M_PI * column / 1800.0;
    for (int ring = 0; ring < 16; ++ring) {
      const double elevation = (2.0 * ring - 15.0) * M_PI / 180.0;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double to_ground = elevation < 0.0 ? -kHeight / ray.z() : 1e9;
      const double distance = std::min(to_ground, range(ray));
      if (distance > 100.0) continue;
      const Eigen::Vector3f p = (kSensor + distance * ray).cast<float>();
      cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
      cloud.times.push_back(static_cast<float>(1e-4 * column));
    }
  }
  return cloud;
}

SampledPoints between(const PointCloud& cloud, RingSurfaces surfaces = RingSurfaces::kAll) {
  SampledPoints points;
  points.viewpoint = kSensor.cast<float>();
  RingInterpolator().interpolate(cloud, {0.05, 0.4, 100.0, surfaces}, points);
  return points;
}

double nothing(const Eigen::Vector3d&) { return 1e9; }

TEST(RingInterpolator, PutsPointsOnTheGroundBetweenRings) {
  const SampledPoints points = between(seen(nothing));
  ASSERT_GT(points.size(), 1000U);
  std::vector<double> distances;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Chords of a ring's circle are below 1 % of its radius inside of it.
    EXPECT_NEAR(points.z[i], 0.0, 1e-3);
    distances.push_back(std::hypot(points.x[i] - kSensor.x(), points.y[i] - kSensor.y()));
  }
  // From the lowest ring to the last one that is not too far from the one before.
  const auto [nearest, farthest] = std::minmax_element(distances.begin(), distances.end());
  EXPECT_GT(*nearest, kHeight / std::tan(15.0 * M_PI / 180.0));
  EXPECT_LT(*farthest, kHeight / std::tan(5.0 * M_PI / 180.0));
  EXPECT_GT(*farthest, 18.0);
}

TEST(RingInterpolator, InterpolatesTheTimes) {
  const SampledPoints points = between(seen(nothing));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double turn = std::atan2(points.y[i], points.x[i] - kSensor.x()) / (2.0 * M_PI);
    EXPECT_NEAR(points.s[i], 0.18 * (turn < 0.0 ? turn + 1.0 : turn) - 0.05, 1e-3);
  }
}

// Behind a post the next ring sees the wall: there is nothing in between.
TEST(RingInterpolator, DoesNotConnectObjectsWithTheirBackground) {
  const auto posts = [](const Eigen::Vector3d& ray) {
    const bool is_low = ray.z() < 0.02;
    return is_low ? 8.0 / std::hypot(ray.x(), ray.y()) : 14.0 / std::hypot(ray.x(), ray.y());
  };
  const SampledPoints points = between(seen(posts));
  ASSERT_GT(points.size(), 500U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = std::hypot(points.x[i] - kSensor.x(), points.y[i] - kSensor.y());
    EXPECT_TRUE(distance < 8.01 || distance > 13.95) << distance;
  }
}

// Walls around a hall, 14 m away: rings are half a metre apart on them.
TEST(RingInterpolator, LeavesOutWallsIfOnlyTheGroundIsWanted) {
  const auto walls = [](const Eigen::Vector3d& ray) { return 14.0 / std::hypot(ray.x(), ray.y()); };
  const auto on_walls = [](const SampledPoints& points) {
    return std::count_if(points.z.begin(), points.z.end(), [](float z) { return z > 0.01F; });
  };
  EXPECT_GT(on_walls(between(seen(walls))), 500);
  const SampledPoints ground = between(seen(walls), RingSurfaces::kGround);
  EXPECT_GT(ground.size(), 500U);
  EXPECT_EQ(on_walls(ground), 0);
}

TEST(RingInterpolator, AddsNothingBetweenCloseRings) {
  const auto wall = [](const Eigen::Vector3d& ray) { return 5.0 / std::hypot(ray.x(), ray.y()); };
  EXPECT_EQ(between(seen(wall)).size(), 0U) << "rings are 0.17 m apart";
}

TEST(RingInterpolator, AddsNothingWithoutViewpoint) {
  SampledPoints points;
  points.x.push_back(1.0F);
  RingInterpolator().interpolate(seen(nothing), {0.05, 0.4, 100.0}, points);
  EXPECT_EQ(points.size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::front_end
