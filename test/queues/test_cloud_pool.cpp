// SPDX-License-Identifier: BSD-3-Clause
#include <future>
#include <utility>

#include <gtest/gtest.h>

#include "threads/cloud_pool.hpp"

namespace lidar_mapping::pipeline {
namespace {

PointCloud cloud_of(std::size_t points) {
  PointCloud cloud;
  cloud.points.resize(points);
  return cloud;
}

TEST(CloudPool, GivesEveryCloudOnce) {
  CloudPool pool;
  EXPECT_EQ(pool.acquire().size(), 0U);
  pool.release(cloud_of(7));
  EXPECT_EQ(pool.acquire().size(), 7U);
  EXPECT_EQ(pool.acquire().size(), 0U);
}

TEST(CloudPool, MayBeUsedByTwoThreads) {
  CloudPool pool;
  const auto use = [&pool] {
    for (int i = 0; i < 1000; ++i) {
      PointCloud cloud = pool.acquire();
      cloud.points.resize(cloud.size() % 100 + 1);
      pool.release(std::move(cloud));
    }
  };
  auto other = std::async(std::launch::async, use);
  use();
  other.get();
  EXPECT_GT(pool.acquire().size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
