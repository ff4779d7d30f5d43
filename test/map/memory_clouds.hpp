// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/cloud_source.hpp"

namespace lidar_mapping::map {

/// Clouds in memory; counts how often they are read.
class MemoryClouds : public CloudSource {
 public:
  PointCloudPtr cloud(KeyFrameIndex index) override {
    ++reads;
    const auto found = clouds.find(index);
    return found == clouds.end() ? nullptr : found->second;
  }
  std::map<KeyFrameIndex, PointCloudPtr> clouds;
  std::size_t reads = 0;
};

inline PointCloudPtr cloud_of(std::vector<Point> points) {
  auto cloud = std::make_shared<PointCloud>();
  cloud->points = std::move(points);
  return cloud;
}

inline void expect_same_bits(const PointCloud& a, const PointCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.points[i].position(), b.points[i].position()) << "point " << i;
    ASSERT_EQ(a.points[i].intensity, b.points[i].intensity) << "point " << i;
  }
}

}  // namespace lidar_mapping::map
