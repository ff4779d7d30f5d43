// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/uneven_turning.hpp"

#include "near.hpp"

namespace lidar_mapping {
namespace {

Eigen::Quaterniond about_z(double angle) { return exp_so3({0.0, 0.0, angle}); }

/// 0, 0.2 and 0.1 rad at 0.05, 0.06 and 0.07 s.
UnevenTurning turning() { return {0.05, 0.01, {about_z(0.0), about_z(0.2), about_z(0.1)}}; }

double angle_at(double time) { return log_so3(turning().at(time)).z(); }

TEST(UnevenTurning, IsLinearBetweenKnots) {
  EXPECT_NEAR(angle_at(0.05), 0.0, 1e-12);
  EXPECT_NEAR(angle_at(0.0525), 0.05, 1e-12);
  EXPECT_NEAR(angle_at(0.06), 0.2, 1e-12);
  EXPECT_NEAR(angle_at(0.065), 0.15, 1e-12);
}

TEST(UnevenTurning, IsHeldBeyondItsEnds) {
  EXPECT_NEAR(angle_at(-1.0), 0.0, 1e-12);
  EXPECT_NEAR(angle_at(0.07), 0.1, 1e-12);
  EXPECT_NEAR(angle_at(9.0), 0.1, 1e-12);
}

TEST(UnevenTurning, HasTheRateOfItsLargestAngle) {
  EXPECT_NEAR(turning().mean_rate(), 0.2 / 0.02, 1e-9);
  EXPECT_EQ((UnevenTurning{0.0, 0.01, {about_z(0.3)}}).mean_rate(), 0.0) << "of one knot";
  EXPECT_EQ(UnevenTurning().mean_rate(), 0.0);
}

TEST(PutBack, TurnsEachPointBackByItsTime) {
  PointCloud cloud;
  cloud.points = {{1.0F, 0.0F, 2.0F, 7.0F}, {1.0F, 0.0F, 2.0F, 8.0F}};
  cloud.times = {0.05F, 0.06F};
  const PointCloud back = put_back(turning(), cloud);
  EXPECT_TRUE(test::near(back.points[0].position(), Eigen::Vector3f(1.0F, 0.0F, 2.0F), 1e-6));
  const Eigen::Vector3f turned(std::cos(0.2F), -std::sin(0.2F), 2.0F);
  EXPECT_TRUE(test::near(back.points[1].position(), turned, 1e-6));
  EXPECT_EQ(back.points[1].intensity, 8.0F);
}

TEST(PutBack, TurnsAPointWhoseTimeIsNotANumberAsAtTheEnd) {
  PointCloud cloud;
  cloud.points = {{1.0F, 0.0F, 2.0F, 7.0F}};
  cloud.times = {std::nanf("")};
  const Eigen::Vector3f turned(std::cos(0.1F), -std::sin(0.1F), 2.0F);
  EXPECT_TRUE(test::near(put_back(turning(), cloud).points[0].position(), turned, 1e-6));
}

TEST(PutBack, LeavesACloudWithoutTimesAlone) {
  PointCloud cloud;
  cloud.points = {{1.0F, 0.0F, 2.0F, 7.0F}};
  EXPECT_EQ(put_back(turning(), cloud).points[0].position(), cloud.points[0].position());
  cloud.times = {0.06F};
  EXPECT_EQ(put_back({}, cloud).points[0].position(), cloud.points[0].position());
}

}  // namespace
}  // namespace lidar_mapping
