// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/free_space_image.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping {
namespace {

using Answer = FreeSpaceImage::FreeSpaceTest;

/// A point in a direction given in degrees.
Eigen::Vector3f at(float range, double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * kPi / 180.0;
  const double elevation = elevation_deg * kPi / 180.0;
  return range * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
                     .cast<float>();
}

/// Returns in the middle of a block of cells of 1.5 by 2 degrees around an azimuth and an elevation
/// of 0.75 and 1 degrees; the ranges are row by row, 0 for none.
FreeSpaceImage image_of(const std::array<float, 9>& ranges) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 9; ++i) {
    const float range = ranges[i];
    if (range == 0.0F) continue;
    points.push_back(at(range, 0.75 + 1.5 * (i % 3 - 1), 1.0 + 2.0 * (i / 3 - 1)));
  }
  return {points, Eigen::Vector3f::Zero()};
}

/// The test of a point in the middle of the block.
Answer test_of(const std::array<float, 9>& ranges, float range) {
  return image_of(ranges).test_free_space(at(range, 0.75, 1.0));
}

TEST(FreeSpaceImage, IsViolatedByAPointClearlyBeforeAllReturnsAround) {
  const std::array<float, 9> wall = {20, 20, 20, 20, 20, 20, 20, 20, 20};
  EXPECT_EQ(test_of(wall, 10.0F), Answer::kViolation);
  EXPECT_EQ(test_of(wall, 18.4F), Answer::kViolation);
  EXPECT_EQ(test_of(wall, 18.6F), Answer::kConsistent) << "1.5 m are within the errors";
  EXPECT_EQ(test_of(wall, 30.0F), Answer::kConsistent) << "it was hidden";
}

TEST(FreeSpaceImage, IsNotViolatedBesideSomethingNear) {
  EXPECT_EQ(test_of({20, 20, 20, 20, 20, 20, 20, 20, 11}, 10.0F), Answer::kConsistent);
  EXPECT_EQ(test_of({12, 20, 20, 20, 20, 20, 20, 20, 20}, 10.0F), Answer::kViolation);
}

TEST(FreeSpaceImage, TestsOnlyWhereItHasReturns) {
  EXPECT_EQ(test_of({20, 20, 20, 20, 0, 20, 20, 20, 20}, 10.0F), Answer::kUntested)
      << "not in the direction itself";
  EXPECT_EQ(test_of({20, 0, 0, 0, 20, 0, 0, 0, 20}, 10.0F), Answer::kUntested) << "three";
  EXPECT_EQ(test_of({20, 0, 20, 0, 20, 0, 0, 0, 20}, 10.0F), Answer::kViolation) << "four";
  EXPECT_EQ(FreeSpaceImage().test_free_space({1.0F, 0.0F, 0.0F}), Answer::kUntested);
}

// At the edge of the field of view the ground may lie right below the last returns.
TEST(FreeSpaceImage, IsFreeOnlyWhereEachRowAroundHasReturns) {
  const auto is_certain_violation = [](const std::array<float, 9>& ranges, float range) {
    return image_of(ranges).is_certain_violation(at(range, 0.75, 1.0));
  };
  EXPECT_TRUE(is_certain_violation({20, 0, 0, 0, 20, 20, 0, 20, 0}, 10.0F));
  EXPECT_FALSE(is_certain_violation({0, 0, 0, 20, 20, 20, 20, 20, 20}, 10.0F)) << "none below";
  EXPECT_FALSE(is_certain_violation({20, 20, 20, 20, 20, 20, 0, 0, 0}, 10.0F)) << "none above";
  EXPECT_FALSE(is_certain_violation({20, 0, 0, 0, 20, 0, 0, 20, 0}, 10.0F)) << "three returns";
  EXPECT_FALSE(is_certain_violation({20, 20, 20, 20, 0, 20, 20, 20, 20}, 10.0F))
      << "not in the direction";
  EXPECT_FALSE(is_certain_violation({20, 20, 20, 20, 20, 20, 11, 20, 20}, 10.0F))
      << "beside something near";
  EXPECT_FALSE(FreeSpaceImage().is_certain_violation({1.0F, 0.0F, 0.0F}));
}

TEST(FreeSpaceImage, KeepsTheNearestReturnOfADirection) {
  std::vector<Eigen::Vector3f> points;
  for (const double azimuth : {-0.75, 0.75, 2.25}) {
    for (const double elevation : {-1.0, 1.0, 3.0}) {
      for (const float range : {30.0F, 12.0F, 25.0F})
        points.push_back(at(range, azimuth, elevation));
    }
  }
  const FreeSpaceImage image(points, Eigen::Vector3f::Zero());
  EXPECT_EQ(image.test_free_space(at(10.0F, 0.75, 1.0)), Answer::kViolation);
  EXPECT_EQ(image.test_free_space(at(11.0F, 0.75, 1.0)), Answer::kConsistent);
}

TEST(FreeSpaceImage, IsSeenFromItsSensor) {
  const Eigen::Vector3f sensor(5.0F, -3.0F, 1.8F);
  std::vector<Eigen::Vector3f> points;
  for (double azimuth = -4.0; azimuth <= 4.0; azimuth += 0.5) {
    for (double elevation = -4.0; elevation <= 4.0; elevation += 0.5) {
      points.push_back(sensor + at(20.0F, azimuth, elevation));
    }
  }
  const FreeSpaceImage image(points, sensor);
  EXPECT_EQ(image.test_free_space(sensor + at(10.0F, 0.0, 0.0)), Answer::kViolation);
  EXPECT_EQ(image.test_free_space(sensor + at(10.0F, 30.0, 0.0)), Answer::kUntested);
}

// The first column of a turn is the neighbour of the last one.
TEST(FreeSpaceImage, IsClosedBehindTheSensor) {
  std::vector<Eigen::Vector3f> points;
  for (const double azimuth : {177.75, 179.25, -179.25}) {
    for (const double elevation : {-1.0, 1.0}) points.push_back(at(20.0F, azimuth, elevation));
  }
  FreeSpaceImage image(points, Eigen::Vector3f::Zero());
  EXPECT_EQ(image.test_free_space(at(10.0F, 179.25, 1.0)), Answer::kViolation);
  EXPECT_EQ(image.test_free_space(at(10.0F, -179.25, 1.0)), Answer::kViolation);
  points.push_back(at(10.5F, -179.25, 1.0));
  image = FreeSpaceImage(points, Eigen::Vector3f::Zero());
  EXPECT_EQ(image.test_free_space(at(10.0F, 179.25, 1.0)), Answer::kConsistent);
}

}  // namespace
}  // namespace lidar_mapping
