// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/scan_pairing.hpp"

#include "near.hpp"

namespace lidar_mapping::pipeline {
namespace {

using test::near;

OdometryStep step_at(Stamp stamp, double x) {
  OdometryStep step;
  step.stamp = stamp;
  step.T_odom_base.translation = {x, 0.0, 0.0};
  step.covariance = diagonal_covariance(0.1, 0.01);
  return step;
}

Scan scan_at(Stamp stamp) { return {stamp, {}}; }

TEST(ScanPairing, PairsByEqualStampsWhicheverComesFirst) {
  ScanPairing pairing;
  pairing.add(scan_at(1));
  EXPECT_TRUE(pairing.take_ready().empty());
  pairing.add(step_at(1, 5.0));
  pairing.add(step_at(2, 6.0));
  pairing.add(scan_at(2));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_FALSE(pairs[0].input.is_connected);  // nothing led to the first one
  EXPECT_EQ(pairs[0].T_odom_base.translation.x(), 5.0);
  EXPECT_TRUE(pairs[1].input.is_connected);
  EXPECT_EQ(pairs[1].input.scan.stamp, 2);
  EXPECT_TRUE(
      near(pairs[1].input.T_previous_base.translation, Eigen::Vector3d(1.0, 0.0, 0.0), 1e-12));
  EXPECT_TRUE(near(pairs[1].input.covariance, diagonal_covariance(0.1, 0.01), 1e-12));
}

/// A scan had the twist of the newest odometry, and that without its covariance.
TEST(ScanPairing, GivesEachScanTheTwistOfItsStamp) {
  ScanPairing pairing;
  for (const Stamp stamp : {1, 2, 3}) {
    OdometryStep step = step_at(stamp, 0.0);
    step.twist.value[0] = static_cast<double>(stamp);
    step.twist.covariance(0, 0) = 0.1 * static_cast<double>(stamp);
    pairing.add(step);
  }
  for (const Stamp stamp : {1, 2}) pairing.add(scan_at(stamp));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].twist.value[0], 1.0);
  EXPECT_EQ(pairs[1].twist.value[0], 2.0);
  EXPECT_EQ(pairs[1].twist.covariance(0, 0), 0.2);
}

TEST(ScanPairing, AddsUpTheMotionOverScansThatWereLost) {
  ScanPairing pairing;
  pairing.add(step_at(1, 0.0));
  pairing.add(scan_at(1));
  ASSERT_EQ(pairing.take_ready().size(), 1U);
  for (const Stamp stamp : {2, 3, 4}) pairing.add(step_at(stamp, static_cast<double>(stamp)));
  pairing.add(scan_at(4));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_TRUE(pairs[0].input.is_connected);
  EXPECT_TRUE(
      near(pairs[0].input.T_previous_base.translation, Eigen::Vector3d(4.0, 0.0, 0.0), 1e-12));
  EXPECT_NEAR(pairs[0].input.covariance(0, 0), 3 * 0.01, 1e-9);  // three independent steps along x
}

TEST(ScanPairing, SaysWhereOdometryBeganAnew) {
  ScanPairing pairing;
  pairing.add(step_at(1, 0.0));
  pairing.add(scan_at(1));
  ASSERT_EQ(pairing.take_ready().size(), 1U);
  OdometryStep restarted = step_at(2, 0.0);
  restarted.covariance.reset();
  pairing.add(restarted);
  pairing.add(step_at(3, 1.0));
  pairing.add(scan_at(3));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_FALSE(pairs[0].input.is_connected);
  EXPECT_TRUE(near(pairs[0].input.T_previous_base, Pose::Identity(), 1e-12));
}

TEST(ScanPairing, GivesUpScansThatOdometryHasPassed) {
  ScanPairing pairing;
  pairing.add(scan_at(1));
  pairing.add(step_at(2, 0.0));
  pairing.add(scan_at(2));
  EXPECT_EQ(pairing.take_ready().size(), 1U);
  EXPECT_EQ(pairing.given_up(), 1U);
}

/// A later step from before would let every scan be given up that comes before its step.
TEST(ScanPairing, DiscardsTheStepsFromBeforeTimeWentBack) {
  ScanPairing pairing;
  pairing.add(step_at(100, 9.0));
  OdometryStep restarted = step_at(1, 0.0);
  restarted.covariance.reset();
  pairing.add(restarted);
  pairing.add(scan_at(2));
  EXPECT_TRUE(pairing.take_ready().empty());
  pairing.add(step_at(2, 1.0));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].T_odom_base.translation.x(), 1.0);
  EXPECT_EQ(pairing.given_up(), 0U);
}

TEST(ScanPairing, KeepsABoundedNumberOfStepsWithoutScans) {
  ScanPairing pairing;
  pairing.add(step_at(1, 0.0));
  pairing.add(scan_at(1));
  ASSERT_EQ(pairing.take_ready().size(), 1U);
  for (Stamp stamp = 2; stamp <= 3000; ++stamp) pairing.add(step_at(stamp, 0.0));
  pairing.add(scan_at(3000));
  const auto pairs = pairing.take_ready();
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_FALSE(pairs[0].input.is_connected) << "the first steps are gone";
}

TEST(ScanPairing, KeepsABoundedNumberOfScansWithoutOdometry) {
  ScanPairing pairing;
  for (Stamp stamp = 1; stamp <= 100; ++stamp) {
    pairing.add(scan_at(stamp));
    EXPECT_TRUE(pairing.take_ready().empty());
  }
  EXPECT_EQ(pairing.given_up(), 80U);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
