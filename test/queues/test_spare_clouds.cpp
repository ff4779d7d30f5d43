// SPDX-License-Identifier: BSD-3-Clause
#include <future>
#include <utility>

#include <gtest/gtest.h>

#include "spare_clouds.hpp"

namespace lidar_mapping::pipeline {
namespace {

PointCloud cloud_of(std::size_t points) {
  PointCloud cloud;
  cloud.points.resize(points);
  return cloud;
}

TEST(SpareClouds, GivesEveryCloudOnce) {
  SpareClouds spare;
  EXPECT_EQ(spare.take().size(), 0U);
  spare.give(cloud_of(7));
  EXPECT_EQ(spare.take().size(), 7U);
  EXPECT_EQ(spare.take().size(), 0U);
}

TEST(SpareClouds, MayBeUsedByTwoThreads) {
  SpareClouds spare;
  const auto use = [&spare] {
    for (int i = 0; i < 1000; ++i) {
      PointCloud cloud = spare.take();
      cloud.points.resize(cloud.size() % 100 + 1);
      spare.give(std::move(cloud));
    }
  };
  auto other = std::async(std::launch::async, use);
  use();
  other.get();
  EXPECT_GT(spare.take().size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
