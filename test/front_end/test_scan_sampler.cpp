// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "scan/scan_sampler.hpp"
#include "scan/sweep_order.hpp"

namespace lidar_mapping::front_end {
namespace {

PointCloud random_cloud(std::size_t count) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> coordinate(-40.0F, 40.0F);
  PointCloud cloud;
  while (cloud.size() < count) {
    cloud.points.push_back({coordinate(engine), coordinate(engine), coordinate(engine), 0.0F});
  }
  return cloud;
}

TEST(ScanSampler, KeepsAtMostOnePointPerCube) {
  PointCloud cloud = random_cloud(20000);  // 8000 cubes
  ScanSampler sampler(17);
  const auto indices = sampler.sample(cloud, {4.0, 0.0, 1000.0, 1, 0});
  EXPECT_GT(indices.size(), 4000U);
  EXPECT_LE(indices.size(), 8000U);
  EXPECT_EQ(sampler.sample(cloud, {4.0, 0.0, 1000.0, 1, 0}), indices);
}

/// A wall 10.2 m to the left, as a sensor that turns clockwise sees it, firing by firing.
PointCloud swept_wall() {
  std::mt19937 engine(3);
  std::normal_distribution<float> noise(0.0F, 0.02F);
  PointCloud cloud;
  for (int column = 0; column < 4000; ++column) {
    const float azimuth = 2.8F - 2.46F * static_cast<float>(column) / 4000.0F;
    for (int beam = 0; beam < 16; ++beam) {
      const float range = 10.2F / std::sin(azimuth) + noise(engine);
      const float height = 0.02F * static_cast<float>(beam - 8) * range;
      cloud.points.push_back({range * std::cos(azimuth), range * std::sin(azimuth), height, 0.0F});
    }
  }
  return cloud;
}

/// Slope over x of the mean distance of the sampled points from the wall.
double leaning(const PointCloud& cloud, bool scattered) {
  ScanSampler sampler(17);
  double products = 0.0;
  double squares = 0.0;
  for (const std::uint32_t i : sampler.sample(cloud, {0.4, 0.0, 1000.0, 1, 0, scattered})) {
    const Point& p = cloud.points[i];
    products += p.x * (p.y - 10.2);
    squares += p.x * p.x;
  }
  return products / squares;
}

// In the order of the sweep, the range noise decides which point of a cube comes first: one that is
// too near on a wall that comes nearer, one that is too far on a wall that recedes.
TEST(ScanSampler, HasNoBiasInTheDirectionOfTheSweep) {
  const PointCloud cloud = swept_wall();
  EXPECT_LT(std::abs(leaning(cloud, true)), 0.3 * std::abs(leaning(cloud, false)));
}

TEST(ScanSampler, ScatteredOrderVisitsEachPointOnce) {
  const PointCloud cloud = random_cloud(5000);
  ScanSampler sampler(20);
  for (const std::size_t stride : {1U, 3U, 9U, 5000U}) {
    std::vector<std::uint32_t> indices =
        sampler.sample(cloud, {1e-3, 0.0, 1000.0, stride, 0, true});
    std::sort(indices.begin(), indices.end());
    EXPECT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end()) << stride;
    EXPECT_EQ(indices.size(), sampler.sample(cloud, {1e-3, 0.0, 1000.0, stride, 0, false}).size());
  }
}

TEST(SweepOrder, IsThatOfTheFirings) {
  PointCloud cloud;
  for (int column = 0; column < 900; ++column) {
    const float azimuth = -0.007F * static_cast<float>(column);
    for (int ring = 0; ring < 16; ++ring) {
      cloud.points.push_back({20.0F * std::cos(azimuth), 20.0F * std::sin(azimuth), 0.0F, 0.0F});
    }
  }
  EXPECT_TRUE(in_sweep_order(cloud));
  PointCloud by_rings;
  for (std::size_t ring = 0; ring < 16; ++ring) {
    for (std::size_t column = 0; column < 900; ++column) {
      by_rings.points.push_back(cloud.points[16 * column + ring]);
    }
  }
  EXPECT_FALSE(in_sweep_order(by_rings));
  EXPECT_FALSE(in_sweep_order(PointCloud{}));
}

TEST(ScanSampler, LeavesOutPointsThatAreNotFiniteOrOutOfRange) {
  PointCloud cloud;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  cloud.points = {
      {nan, 0, 0, 0}, {5, infinite, 0, 0}, {0.5F, 0, 0, 0}, {200, 0, 0, 0}, {5, 5, 5, 0}};
  ScanSampler sampler(10);
  EXPECT_EQ(sampler.sample(cloud, {1.0, 1.0, 100.0, 1, 0}), std::vector<std::uint32_t>{4});
}

TEST(ScanSampler, SamplesEquallyAfterTheGenerationWraps) {
  const PointCloud cloud = random_cloud(500);
  ScanSampler sampler(14);
  const auto first = sampler.sample(cloud, {1.0, 0.0, 1000.0, 1, 0});
  for (int i = 0; i < 600; ++i) {
    ASSERT_EQ(sampler.sample(cloud, {1.0, 0.0, 1000.0, 1, 0}), first) << i;
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
