// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/spherical_projection.hpp"

namespace lidar_mapping {
namespace {

// Pixels of 10 degrees.
constexpr int kRows = 18;
constexpr int kColumns = 36;

void expect_pixel(const Eigen::Vector3f& ray, int row, int column) {
  const SphericalPixel pixel = spherical_pixel(ray, kRows, kColumns);
  EXPECT_EQ(pixel.row, row) << ray.transpose();
  EXPECT_EQ(pixel.column, column) << ray.transpose();
}

TEST(SphericalPixel, TurnsFromBehindOverTheRight) {
  expect_pixel({-1.0F, -0.1F, 0.1F}, 9, 0);
  expect_pixel({0.1F, -1.0F, 0.1F}, 9, 9);
  expect_pixel({1.0F, 0.1F, 0.1F}, 9, 18);
  expect_pixel({-0.1F, 1.0F, 0.1F}, 9, 27);
  expect_pixel({-1.0F, 0.1F, 0.1F}, 9, 35);
}

TEST(SphericalPixel, RisesFromStraightDown) {
  expect_pixel({1.0F, 0.1F, -20.0F}, 0, 18);
  expect_pixel({1.0F, 0.1F, -0.1F}, 8, 18);
  expect_pixel({1.0F, 0.1F, 20.0F}, 17, 18);
}

TEST(SphericalPixel, StaysInTheImageAtItsEdges) {
  EXPECT_EQ(spherical_pixel({0.0F, 0.0F, 1.0F}, kRows, kColumns).row, kRows - 1);
  EXPECT_EQ(spherical_pixel({0.0F, 0.0F, -1.0F}, kRows, kColumns).row, 0);
  EXPECT_EQ(spherical_pixel({-1.0F, 0.0F, 0.0F}, kRows, kColumns).column, kColumns - 1);
}

TEST(SphericalPixel, DoesNotDependOnTheLength) {
  expect_pixel({300.0F, 30.0F, 30.0F}, 9, 18);
  expect_pixel({0.03F, 0.003F, 0.003F}, 9, 18);
}

}  // namespace
}  // namespace lidar_mapping
