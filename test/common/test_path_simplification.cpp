// SPDX-License-Identifier: BSD-3-Clause

#include <gtest/gtest.h>

#include "lidar_mapping/common/path_simplification.hpp"

namespace lidar_mapping {
namespace {

using Path = std::vector<Eigen::Vector3d>;
using Positions = std::vector<std::size_t>;

TEST(PathSimplification, KeepsAllPointsOfAShortPath) {
  EXPECT_TRUE(simplified_path({}, 2).empty());
  EXPECT_EQ(simplified_path({{0.0, 0.0, 0.0}}, 2), (Positions{0}));
  EXPECT_EQ(simplified_path(Path(3, Eigen::Vector3d::Zero()), 3), (Positions{0, 1, 2}));
}

TEST(PathSimplification, KeepsTheEndsAndTheGreatestBends) {
  const Path path = {{0.0, 0.0, 0.0}, {1.0, 0.1, 0.0}, {2.0, 0.0, 5.0}, {3.0, 0.0, 0.0},
                     {4.0, 2.0, 0.0}, {5.0, 0.0, 0.0}, {6.0, 0.0, 0.0}};
  EXPECT_EQ(simplified_path(path, 2), (Positions{0, 6}));
  EXPECT_EQ(simplified_path(path, 3), (Positions{0, 2, 6})) << "also a bend upwards";
  EXPECT_EQ(simplified_path(path, 5), (Positions{0, 2, 3, 4, 6}));
}

/// The third point is 10 m from the line that the second one begins, but that line is only drawn
/// because of the second one.
TEST(PathSimplification, AddsNoPointBeforeTheOneThatMakesItStandOut) {
  const Path path = {{0.0, 0.0, 0.0}, {10.0, 5.0, 0.0}, {0.0, 4.9, 0.0}, {10.0, 0.0, 0.0}};
  EXPECT_EQ(simplified_path(path, 3), (Positions{0, 1, 3}));
}

TEST(PathSimplification, MeasuresBeyondTheEndsOfALineFromThese) {
  // The second point lies on the extended line, but 10 m before its begin.
  const Path path = {{0.0, 0.0, 0.0}, {-10.0, 0.0, 0.0}, {5.0, 2.0, 0.0}, {10.0, 0.0, 0.0}};
  EXPECT_EQ(simplified_path(path, 3), (Positions{0, 1, 3}));
}

TEST(PathSimplification, FillsUpWithTheFirstPointsOfAStraightPath) {
  Path path;
  for (int i = 0; i < 10; ++i) path.push_back({1.0 * i, 0.0, 0.0});
  EXPECT_EQ(simplified_path(path, 4), (Positions{0, 1, 2, 9}));
}

}  // namespace
}  // namespace lidar_mapping
