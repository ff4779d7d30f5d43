// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"

#include "near.hpp"

namespace lidar_mapping::loop_closing {
namespace {

/// More voxels than the initial table can hold, on both sides of the axes.
PointCloud scattered() {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> coordinate(-30.0F, 30.0F);
  PointCloud cloud;
  for (int i = 0; i < 60000; ++i) {
    cloud.points.push_back(
        {coordinate(random), coordinate(random), 0.1F * coordinate(random), 0.0F});
  }
  return cloud;
}

TEST(VoxelMeans, AgreesWithTheVoxelFilter) {
  const PointCloud cloud = scattered();
  const PointCloud expected = voxel_filtered(cloud, 0.5);
  const auto points = VoxelMeans().filtered(cloud, 0.5);
  ASSERT_GT(points.size(), 20000U);
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(test::near(points[i], expected.points[i].position(), 2e-5F)) << i;
  }
}

TEST(VoxelMeans, ResetRemovesAllPoints) {
  VoxelMeans voxels;
  for (int round = 0; round < 2; ++round) {
    voxels.reset(1.0);
    voxels.add({0.1F, 0.1F, 0.1F});
    voxels.add({-0.1F, 0.1F, 0.1F});
    voxels.add({0.3F, 0.3F, 0.3F});
    const auto points = voxels.points();
    ASSERT_EQ(points.size(), 2U);
    EXPECT_TRUE(points[0].isApprox(Eigen::Vector3f::Constant(0.2F)));
  }
}

TEST(VoxelMeans, ExcludesInvalidPointsAndKeepsAllWithoutALeaf) {
  VoxelMeans voxels;
  voxels.reset(0.0);
  voxels.add({1.0F, 2.0F, 3.0F});
  voxels.add({1.0F, 2.0F, 3.0F});
  voxels.add({std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F});
  voxels.add({0.0F, std::numeric_limits<float>::infinity(), 0.0F});
  voxels.add({0.0F, 0.0F, -1e30F});
  EXPECT_EQ(voxels.points(), std::vector<Eigen::Vector3f>(2, {1.0F, 2.0F, 3.0F}));
}

// The smallest leaf at the ends of the range.
TEST(VoxelMeans, DistinguishesDistantCells) {
  VoxelMeans voxels;
  voxels.reset(0.05);
  std::vector<Eigen::Vector3f> corners;
  for (const float x : {-49'999.0F, 49'999.0F}) {
    for (const float y : {-49'999.0F, 49'999.0F}) {
      for (const float z : {-49'999.0F, 0.01F, 49'999.0F}) corners.emplace_back(x, y, z);
    }
  }
  for (const auto& corner : corners) voxels.add(corner);
  const auto points = voxels.points();
  ASSERT_EQ(points.size(), corners.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(test::near(points[i], corners[i], 0.05F));
  }
}

}  // namespace
}  // namespace lidar_mapping::loop_closing
