// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/scan_assembler.hpp"

#include "near.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kPeriod = 100000000;

Scan scan_at(Stamp stamp) { return {stamp, {{Point{1.0F, 0.0F, 0.0F, 0.0F}}, {}}}; }

ImuSample imu_at(Stamp stamp) {
  ImuSample sample;
  sample.stamp = stamp;
  sample.angular_velocity.z() = static_cast<double>(stamp);
  return sample;
}

VelocitySample velocity_at(Stamp stamp) {
  VelocitySample sample;
  sample.stamp = stamp;
  sample.linear.x() = static_cast<double>(stamp);
  return sample;
}

GnssPosition gnss_at(Stamp stamp) {
  GnssPosition position;
  position.stamp = stamp;
  position.p_enu_antenna = {10.0, 1.0, 0.0};
  position.p_base_antenna = {1.0, 0.0, 0.0};
  position.R_enu_base = exp_so3({0.0, 0.0, M_PI / 2});
  return position;
}

std::vector<Stamp> stamps(const std::vector<AssembledScan>& scans) {
  std::vector<Stamp> result;
  for (const AssembledScan& scan : scans) result.push_back(scan.scan.stamp);
  return result;
}

TEST(ScanAssembler, PairsByStampWhateverArrivesFirst) {
  ScanAssembler assembler(false);
  assembler.add_scan(scan_at(kPeriod));
  assembler.add_inputs(kPeriod, {true, true, true});
  assembler.add_velocity(velocity_at(kPeriod));
  EXPECT_TRUE(assembler.take_ready().empty());
  assembler.add_gnss(gnss_at(kPeriod));
  assembler.add_imu(imu_at(kPeriod));
  const auto ready = assembler.take_ready();
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_EQ(ready[0].prior.angular_velocity->z(), static_cast<double>(kPeriod));
  EXPECT_EQ(ready[0].prior.linear_velocity->x(), static_cast<double>(kPeriod));
}

// What the gyro took out is told apart from its mean.
TEST(ScanAssembler, HandsOnWhatTheGyroTookOut) {
  ScanAssembler assembler(false);
  const UnevenTurning turning{-0.1, 0.002, {exp_so3({0.1, 0.0, 0.0}), exp_so3({0.0, 0.2, 0.0})}};
  assembler.add_inputs(kPeriod, {false, false, false, turning});
  assembler.add_scan(scan_at(kPeriod));
  assembler.add_inputs(2 * kPeriod, {});
  assembler.add_scan(scan_at(2 * kPeriod));
  const auto ready = assembler.take_ready();
  ASSERT_EQ(ready.size(), 2U);
  ASSERT_TRUE(ready[0].prior.uneven_turning);
  EXPECT_EQ(ready[0].prior.uneven_turning->R_stamp_knot.size(), 2U);
  EXPECT_FALSE(ready[1].prior.uneven_turning);
}

// The scan that comes with it was moved by measured motion.
TEST(ScanAssembler, HandsOnTheFingerprintOfTheDriversPoints) {
  ScanAssembler assembler(false);
  assembler.add_inputs(kPeriod, {false, false, false, std::nullopt, std::nullopt, 42});
  assembler.add_scan(scan_at(kPeriod));
  const auto ready = assembler.take_ready();
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_EQ(ready[0].prior.fingerprint, 42U);
}

// Two scans that came before the IMU's sample of the first were taken without it.
TEST(ScanAssembler, WaitsForWhatIsNamedHoweverManyScansComeFirst) {
  ScanAssembler assembler(false);
  for (int i = 1; i <= 3; ++i) {
    assembler.add_scan(scan_at(i * kPeriod));
    assembler.add_inputs(i * kPeriod, {true, true, i > 1});
  }
  EXPECT_TRUE(assembler.take_ready().empty());
  for (int i = 1; i <= 3; ++i) {
    assembler.add_imu(imu_at(i * kPeriod));
    EXPECT_TRUE(assembler.take_ready().empty());
    assembler.add_velocity(velocity_at(i * kPeriod));
    const auto ready = assembler.take_ready();
    ASSERT_EQ(ready.size(), 1U) << "of GNSS only the first pose is used";
    EXPECT_EQ(ready[0].prior.angular_velocity->z(), static_cast<double>(i * kPeriod));
    EXPECT_TRUE(ready[0].prior.linear_velocity);
  }
}

TEST(ScanAssembler, DoesNotWaitForWhatIsNotNamed) {
  ScanAssembler assembler(false);
  assembler.add_scan(scan_at(kPeriod));
  EXPECT_TRUE(assembler.take_ready().empty());
  assembler.add_inputs(kPeriod, {});
  EXPECT_EQ(assembler.take_ready().size(), 1U);
}

TEST(ScanAssembler, GoesOnWithoutASampleThatWasLost) {
  ScanAssembler assembler(false);
  std::size_t taken = 0;
  for (int i = 1; i <= 12; ++i) {
    assembler.add_scan(scan_at(i * kPeriod));
    assembler.add_inputs(i * kPeriod, {true, false, false});
    if (i != 2) assembler.add_imu(imu_at(i * kPeriod));
    taken += assembler.take_ready().size();
    EXPECT_EQ(taken, i < 12 ? 1U : 12U);
  }
  EXPECT_EQ(assembler.scans_without_samples(), 1U);
}

TEST(ScanAssembler, TakesNoTurningFromAnImuWithoutGyro) {
  ScanAssembler assembler(false);
  assembler.add_scan(scan_at(kPeriod));
  ImuSample imu = imu_at(kPeriod);
  imu.has_angular_velocity = false;
  assembler.add_imu(imu);
  const auto out = assembler.flush();
  ASSERT_EQ(out.size(), 1U);
  EXPECT_FALSE(out[0].prior.angular_velocity);
}

// Pairing by nearness; here a sample of another stamp must never be taken.
TEST(ScanAssembler, NeverTakesASampleOfAnotherStamp) {
  ScanAssembler assembler(false);
  assembler.add_imu(imu_at(kPeriod + 1));
  assembler.add_scan(scan_at(kPeriod));
  const auto out = assembler.flush();
  ASSERT_EQ(out.size(), 1U);
  EXPECT_FALSE(out[0].prior.angular_velocity);
}

// LiDAR alone must work.
TEST(ScanAssembler, WaitsForSilentSensorsOnlyOnce) {
  ScanAssembler assembler(false);
  for (int i = 1; i <= 10; ++i) assembler.add_scan(scan_at(i * kPeriod));
  EXPECT_TRUE(assembler.take_ready().empty()) << "the inputs may still be named";
  assembler.add_scan(scan_at(11 * kPeriod));
  EXPECT_EQ(assembler.take_ready().size(), 11U);
  assembler.add_scan(scan_at(12 * kPeriod));
  EXPECT_EQ(assembler.take_ready().size(), 1U);
}

TEST(ScanAssembler, AfterARestNothingIsWaitedForAnyLonger) {
  ScanAssembler assembler(false);
  for (int i = 1; i <= 2; ++i) assembler.add_scan(scan_at(i * kPeriod));
  EXPECT_EQ(stamps(assembler.flush()), (std::vector<Stamp>{kPeriod, 2 * kPeriod}));
  for (int i = 3; i <= 4; ++i) assembler.add_scan(scan_at(i * kPeriod));
  EXPECT_EQ(assembler.take_ready().size(), 2U);
}

TEST(ScanAssembler, ASensorThatSpeaksAgainIsWaitedForAgain) {
  ScanAssembler assembler(false);
  assembler.add_scan(scan_at(1 * kPeriod));
  assembler.flush();
  for (int i = 2; i <= 3; ++i) assembler.add_scan(scan_at(i * kPeriod));
  EXPECT_EQ(assembler.take_ready().size(), 2U);
  assembler.add_imu(imu_at(4 * kPeriod));
  assembler.add_scan(scan_at(4 * kPeriod));
  EXPECT_EQ(assembler.take_ready().size(), 1U);
  assembler.add_scan(scan_at(5 * kPeriod));
  EXPECT_TRUE(assembler.take_ready().empty());
  assembler.add_imu(imu_at(5 * kPeriod));
  const auto ready = assembler.take_ready();
  ASSERT_EQ(ready.size(), 1U);
  EXPECT_TRUE(ready[0].prior.angular_velocity);
}

TEST(ScanAssembler, InitialPoseIsThatOfTheVehicleNotOfTheAntenna) {
  ScanAssembler assembler(false);
  assembler.add_gnss(gnss_at(kPeriod));
  assembler.add_scan(scan_at(kPeriod));
  const auto out = assembler.flush();
  const Pose pose = out.at(0).prior.T_odom_base_initial.value();
  EXPECT_TRUE(test::near(pose.translation, Eigen::Vector3d(10.0, 0.0, 0.0), 1e-12));
}

TEST(ScanAssembler, WithoutHeadingThereIsNoInitialPose) {
  ScanAssembler assembler(false);
  GnssPosition position = gnss_at(kPeriod);
  position.R_enu_base.reset();
  assembler.add_gnss(position);
  assembler.add_scan(scan_at(kPeriod));
  EXPECT_FALSE(assembler.flush().at(0).prior.T_odom_base_initial);
}

TEST(ScanAssembler, OutsideOdometryIsInterpolatedAtTheScan) {
  ScanAssembler assembler(true);
  assembler.add_odometry(kPeriod, {Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.0}});
  for (int i = 0; i < 2; ++i) assembler.add_scan(scan_at(kPeriod + (1 + i) * kPeriod / 4));
  for (int i = 0; i < 2; ++i) assembler.add_inputs(kPeriod + (1 + i) * kPeriod / 4, {});
  EXPECT_TRUE(assembler.take_ready().empty()) << "nothing is extrapolated";
  assembler.add_odometry(2 * kPeriod, {Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}});
  const auto ready = assembler.take_ready();
  ASSERT_GE(ready.size(), 1U);
  EXPECT_NEAR(ready[0].prior.T_external_base->translation.x(), 0.25, 1e-12);
}

TEST(ScanAssembler, LeavesOutScansInAGapOfTheOutsideOdometry) {
  ScanAssembler assembler(true);
  assembler.add_odometry(0, Pose());
  assembler.add_odometry(10 * kPeriod, Pose());
  assembler.add_scan(scan_at(5 * kPeriod));
  EXPECT_TRUE(assembler.flush().empty());
  EXPECT_EQ(assembler.scans_without_odometry(), 1U);
}

// Arrival order was taken for time order.
TEST(ScanAssembler, RefusesStampsThatGoBackAndKeepsTheOthers) {
  ScanAssembler assembler(false);
  assembler.add_scan(scan_at(2 * kPeriod));
  EXPECT_THROW(assembler.add_scan(scan_at(kPeriod)), InputError);
  EXPECT_THROW(assembler.add_scan(scan_at(2 * kPeriod)), InputError);
  assembler.add_scan(scan_at(3 * kPeriod));
  EXPECT_EQ(stamps(assembler.flush()), (std::vector<Stamp>{2 * kPeriod, 3 * kPeriod}));
}

TEST(ScanAssembler, ASilentExternalOdometryUsesNoMemory) {
  ScanAssembler assembler(true);
  for (int i = 1; i <= 1000; ++i) {
    assembler.add_scan(scan_at(i * kPeriod));
    assembler.take_ready();
  }
  EXPECT_GE(assembler.scans_without_odometry(), 900U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
