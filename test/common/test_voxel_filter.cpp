// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/common/voxel_filter.hpp"

namespace lidar_mapping {
namespace {

TEST(VoxelFilter, ReturnsTheCentroidOfEachVoxel) {
  PointCloud cloud;
  cloud.points = {{0.1F, 0.1F, 0.1F, 1.0F}, {0.3F, 0.1F, 0.1F, 3.0F}, {5.0F, 0.0F, 0.0F, 2.0F}};
  cloud.times = {0.0F, 0.2F, 0.5F};
  const PointCloud filtered = voxel_filtered(cloud, 1.0);
  ASSERT_EQ(filtered.size(), 2U);
  EXPECT_FLOAT_EQ(filtered.points[0].x, 0.2F);
  EXPECT_FLOAT_EQ(filtered.points[0].intensity, 2.0F);
  EXPECT_FLOAT_EQ(filtered.times[0], 0.1F);
  EXPECT_FLOAT_EQ(filtered.points[1].x, 5.0F);
}

TEST(VoxelFilter, DoesNotGiveUpOnALargeExtent) {
  PointCloud cloud;
  for (int i = 0; i < 1000; ++i) cloud.points.push_back({0.0001F * static_cast<float>(i), 0, 0, 0});
  cloud.points.push_back({100000.0F, 100000.0F, 0.0F, 0.0F});
  EXPECT_EQ(voxel_filtered(cloud, 0.1).size(), 2U);
}

TEST(VoxelFilter, LeavesOutWhatIsNotFinite) {
  PointCloud cloud;
  cloud.points = {{std::numeric_limits<float>::quiet_NaN(), 0, 0, 0}, {1, 1, 1, 1}};
  EXPECT_EQ(voxel_filtered(cloud, 0.5).size(), 1U);
}

TEST(ParallelChunks, CoversEveryIndexOnceForAnyNumberOfThreads) {
  for (const int threads : {1, 2, 4}) {
    std::vector<int> touched(1003, 0);
    parallel_chunks(touched.size(), 100, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++touched[i];
    });
    EXPECT_EQ(std::count(touched.begin(), touched.end(), 1), 1003);
  }
}

}  // namespace
}  // namespace lidar_mapping
