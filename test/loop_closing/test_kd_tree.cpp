// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "matching/kd_tree.hpp"

namespace lidar_mapping::loop_closing {
namespace {

std::vector<Eigen::Vector3f> random_points(std::size_t count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> coordinate(-10.0F, 10.0F);
  std::vector<Eigen::Vector3f> points(count);
  for (auto& p : points) p = {coordinate(generator), coordinate(generator), coordinate(generator)};
  return points;
}

std::vector<float> sorted_distances(const std::vector<Eigen::Vector3f>& points,
                                    const Eigen::Vector3f& p) {
  std::vector<float> distances;
  for (const auto& q : points) distances.push_back((q - p).squaredNorm());
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(KdTree, AgreesWithALinearSearch) {
  const KdTree tree(random_points(2000, 1));
  for (const auto& p : random_points(200, 2)) {
    const auto expected = sorted_distances(tree.points(), p);
    const auto nearest = tree.nearest(p, 100.0F);
    ASSERT_TRUE(nearest);
    EXPECT_FLOAT_EQ(nearest->squared_distance, expected.front());
    const auto several = tree.nearest(p, std::size_t{10});
    ASSERT_EQ(several.size(), 10U);
    for (std::size_t i = 0; i < 10; ++i) EXPECT_FLOAT_EQ(several[i].squared_distance, expected[i]);
  }
}

TEST(KdTree, GivesTheDistanceOfTheSecondNearest) {
  const KdTree tree(random_points(2000, 1));
  for (const auto& p : random_points(200, 2)) {
    const auto expected = sorted_distances(tree.points(), p);
    const auto lead = tree.nearest_with_second(p, 100.0F);
    ASSERT_TRUE(lead);
    EXPECT_FLOAT_EQ(lead->nearest.squared_distance, expected[0]);
    EXPECT_FLOAT_EQ(lead->second_squared_distance, expected[1]);
    const float limit = 0.5F * (std::sqrt(expected[0]) + std::sqrt(expected[1]));
    EXPECT_FLOAT_EQ(tree.nearest_with_second(p, limit)->second_squared_distance, limit * limit);
    EXPECT_FALSE(tree.nearest_with_second(p, 0.5F * std::sqrt(expected[0])));
  }
}

TEST(KdTree, FindsNothingBeyondTheLimit) {
  const KdTree tree({{1.0F, 0.0F, 0.0F}});
  EXPECT_FALSE(tree.nearest(Eigen::Vector3f::Zero(), 0.9F));
  EXPECT_TRUE(tree.nearest(Eigen::Vector3f::Zero(), 1.1F));
}

TEST(KdTree, AcceptsEqualPointsAndNoPoints) {
  const KdTree equal(std::vector<Eigen::Vector3f>(100, Eigen::Vector3f::Ones()));
  EXPECT_EQ(equal.nearest(Eigen::Vector3f::Zero(), std::size_t{7}).size(), 7U);
  EXPECT_TRUE(equal.nearest(Eigen::Vector3f::Zero(), std::size_t{0}).empty());
  EXPECT_FALSE(KdTree().nearest(Eigen::Vector3f::Zero(), 1.0F));
  EXPECT_TRUE(KdTree(std::vector<Eigen::Vector3f>())
                  .nearest(Eigen::Vector3f::Zero(), std::size_t{3})
                  .empty());
}

}  // namespace
}  // namespace lidar_mapping::loop_closing
