// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include "matching/correspondence_cache.hpp"

namespace lidar_mapping::loop_closing {
namespace {

std::vector<Eigen::Vector3f> random_points(std::size_t count, std::mt19937& generator) {
  std::uniform_real_distribution<float> coordinate(-10.0F, 10.0F);
  std::vector<Eigen::Vector3f> points(count);
  for (auto& p : points) p = {coordinate(generator), coordinate(generator), coordinate(generator)};
  return points;
}

// As in a registration: steps and limits decrease.
TEST(CorrespondenceCache, AgreesWithASearchEachTime) {
  std::mt19937 generator(1);
  const KdTree tree(random_points(3000, generator));
  std::vector<Eigen::Vector3f> moving = random_points(500, generator);
  CorrespondenceCache memory(tree, moving.size());
  std::normal_distribution<float> normal;
  int found = 0;
  int missed = 0;
  for (const float limit : {3.0F, 1.5F, 0.7F, 0.4F}) {
    for (const float step : {0.3F, 0.1F, 0.02F, 0.0F}) {
      for (std::size_t i = 0; i < moving.size(); ++i) {
        moving[i] +=
            step * Eigen::Vector3f(normal(generator), normal(generator), normal(generator));
        const auto expected = tree.nearest(moving[i], limit);
        const auto pair = memory.nearest(i, moving[i], limit);
        ASSERT_EQ(pair.has_value(), expected.has_value());
        ++(pair ? found : missed);
        if (!pair) continue;
        EXPECT_EQ(pair->index, expected->index);
        EXPECT_FLOAT_EQ(pair->squared_distance, expected->squared_distance);
      }
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(missed, 1000);
}

TEST(CorrespondenceCache, AcceptsATreeOfOnePointOrNone) {
  const KdTree one({{1.0F, 0.0F, 0.0F}});
  CorrespondenceCache memory(one, 1);
  EXPECT_TRUE(memory.nearest(0, Eigen::Vector3f::Zero(), 2.0F));
  EXPECT_TRUE(memory.nearest(0, Eigen::Vector3f(0.2F, 0.0F, 0.0F), 2.0F));
  EXPECT_FALSE(memory.nearest(0, Eigen::Vector3f(-2.0F, 0.0F, 0.0F), 2.0F));
  const KdTree none;
  EXPECT_FALSE(CorrespondenceCache(none, 1).nearest(0, Eigen::Vector3f::Zero(), 2.0F));
}

}  // namespace
}  // namespace lidar_mapping::loop_closing
