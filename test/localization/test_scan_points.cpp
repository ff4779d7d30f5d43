// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "scan_points.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

PointCloud cloud_of(const std::vector<Eigen::Vector3f>& points) {
  PointCloud cloud;
  for (const Eigen::Vector3f& p : points) cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
  return cloud;
}

TEST(ScanPointSampler, TakesOnePointOfEachCube) {
  ScanPointSampler sampler;
  const ScanPoints points = sampler.sample(
      cloud_of({{5.1F, 5.1F, 0.1F}, {5.2F, 5.2F, 0.2F}, {7.5F, 5.1F, 0.1F}}), {0.0, 0.0, 0.0});
  EXPECT_EQ(points.all.size(), 2U);
}

TEST(ScanPointSampler, SeparatesNearPointsFromStructure) {
  ScanPointSampler sampler;
  const ScanPoints points = sampler.sample(cloud_of({{5.0F, 0.0F, 0.0F},
                                                     {6.0F, 0.0F, 2.0F},
                                                     {60.0F, 0.0F, 2.0F},
                                                     {90.0F, 0.0F, 2.0F},
                                                     {NAN, 0.0F, 0.0F}}),
                                           {0.0, 0.0, 1.8});
  EXPECT_EQ(points.all.size(), 3U);
  EXPECT_EQ(points.near.size(), 2U);
  EXPECT_EQ(points.structure.size(), 1U);
  ASSERT_TRUE(points.all.viewpoint().has_value());
  EXPECT_FLOAT_EQ(points.all.viewpoint()->z(), 1.8F);
}

TEST(ScanPointSampler, BoundsTheNumberOfPoints) {
  ScanPointSampler sampler;
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 200'000; ++i) {
    points.emplace_back(static_cast<float>(i % 150) - 75.0F, static_cast<float>(i / 150 % 20),
                        static_cast<float>(i / 3000 % 70));
  }
  EXPECT_LE(sampler.sample(cloud_of(points), {0.0, 0.0, 0.0}).all.size(), 16384U);
  EXPECT_EQ(sampler.sample(cloud_of({}), {0.0, 0.0, 0.0}).all.size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::localization::test
