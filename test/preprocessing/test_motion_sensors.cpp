// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"

#include "motion/motion_sensors.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;
using test::imu;
using test::near;
using test::velocity;

/// "turned" looks to the left at (2, 1, 0) m, "ahead" ahead at the same place, "base" is base_link.
std::optional<Pose> mounting(const std::string& frame) {
  const Eigen::Vector3d lever(2.0, 1.0, 0.0);
  if (frame == "base") return Pose::Identity();
  if (frame == "ahead") return Pose{Eigen::Quaterniond::Identity(), lever};
  if (frame == "turned") return Pose{rotation_about_z(0.5 * kPi), lever};
  return std::nullopt;
}

class MotionSensorsTest : public testing::Test {
 protected:
  /// The sensors with a configuration of their own.
  MotionSensors configured(const PreprocessingConfig& config) { return {config, extrinsics_}; }

  /// Samples each 10 ms from `begin` to `end`, s.
  void turn(double begin, double end, double rate, const std::string& frame = "base") {
    for (int i = static_cast<int>(std::lround(100.0 * begin)); i <= std::lround(100.0 * end); ++i) {
      sensors_.add_imu(imu(at(0.01 * i), {0.0, 0.0, rate}), frame);
    }
  }
  void drive(double begin, double end, const Eigen::Vector3d& linear, double rate = 0.0) {
    for (int i = static_cast<int>(std::lround(100.0 * begin)); i <= std::lround(100.0 * end); ++i) {
      sensors_.add_velocity(velocity(at(0.01 * i), linear, {0.0, 0.0, rate}), "base");
    }
  }
  /// The motion over a scan that begins at its stamp, at(0).
  MeasuredMotion motion(double end, const Eigen::Vector3d& p_base = Eigen::Vector3d::Zero()) {
    return sensors_.motion(at(0.0), {0.0, end}, p_base);
  }

  const Extrinsics extrinsics_{mounting};
  MotionSensors sensors_{{}, extrinsics_};
};

TEST_F(MotionSensorsTest, ASampleIsInSiUnitsAndInTheAxesOfTheVehicle) {
  PreprocessingConfig config;
  config.imu_acceleration_unit = AccelerationUnit::kStandardGravity;
  config.imu_angular_unit = AngularUnit::kDegrees;
  config.imu_time_offset = 0.01;
  MotionSensors sensors = configured(config);
  ImuSample sample = imu(at(0.0), {90.0, 0.0, 0.0});
  sample.linear_acceleration = {0.5, 0.0, 1.0};
  EXPECT_EQ(sensors.add_imu(sample, "turned"), Insertion::kInserted);
  EXPECT_FALSE(sensors.imu_at(at(0.0)));
  const auto found = sensors.imu_at(at(0.01));
  ASSERT_TRUE(found);
  EXPECT_TRUE(near(found->angular_velocity, Eigen::Vector3d(0.0, 0.5 * kPi, 0.0), 1e-12));
  EXPECT_TRUE(near(found->linear_acceleration,
                   Eigen::Vector3d(0.0, 0.5 * kStandardGravity, kStandardGravity), 1e-12));
}

TEST_F(MotionSensorsTest, AnOrientationThatIsNoneIsLeftOut) {
  for (const double norm : {0.9, 1.04}) {
    ImuSample sample = imu(at(norm));
    sample.orientation = Eigen::Quaterniond(norm, 0.0, 0.0, 0.0);
    sensors_.add_imu(sample, "base");
  }
  EXPECT_FALSE(sensors_.imu_at(at(0.9))->orientation);
  ASSERT_TRUE(sensors_.imu_at(at(1.04))->orientation);
  EXPECT_NEAR(sensors_.imu_at(at(1.04))->orientation->norm(), 1.0, 1e-12);
}

TEST_F(MotionSensorsTest, ASampleThatIsNoMeasurementIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(sensors_.add_imu(imu(at(0.0), {nan, 0.0, 0.0}), "base"), Insertion::kRefused);
  EXPECT_EQ(sensors_.add_velocity(velocity(at(0.0), {250.0, 0.0, 0.0}), "base"),
            Insertion::kRefused);
  EXPECT_TRUE(sensors_.imu().buffer().empty());
  EXPECT_TRUE(sensors_.velocity().buffer().empty());
}

TEST_F(MotionSensorsTest, NothingIsKnownInAGapNorWithoutATransform) {
  sensors_.add_imu(imu(at(0.0), {0.0, 0.0, 0.1}), "base");
  sensors_.add_imu(imu(at(0.2), {0.0, 0.0, 0.3}), "base");
  sensors_.add_imu(imu(at(0.5), {0.0, 0.0, 0.3}), "base");
  ASSERT_TRUE(sensors_.imu_at(at(0.1)));
  EXPECT_NEAR(sensors_.imu_at(at(0.1))->angular_velocity.z(), 0.2, 1e-12);
  EXPECT_FALSE(sensors_.imu_at(at(0.35))) << "samples 0.3 s apart";
  sensors_.add_imu(imu(at(0.6)), "elsewhere");
  EXPECT_FALSE(sensors_.imu_at(at(0.6)));
}

// A sensor beside the axis moves with the turn of the vehicle, too: v + omega x (2, 1, 0).
TEST_F(MotionSensorsTest, TheVelocityIsThatOfTheOriginOfBaseLink) {
  sensors_.add_imu(imu(at(0.0), {0.0, 0.0, 0.5}), "base");
  sensors_.add_velocity(velocity(at(0.0), {5.0, 0.0, 0.0}), "ahead");
  ASSERT_TRUE(sensors_.velocity_at(at(0.0)));
  const VelocitySample by_gyro = *sensors_.velocity_at(at(0.0));
  EXPECT_TRUE(near(by_gyro.linear, Eigen::Vector3d(5.5, -1.0, 0.0), 1e-12));
  EXPECT_TRUE(near(by_gyro.angular, Eigen::Vector3d(0.0, 0.0, 0.5), 1e-12));
  sensors_.add_velocity(velocity(at(0.1), {5.0, 0.0, 0.0}, {0.0, 0.0, 0.2}), "ahead");
  ASSERT_TRUE(sensors_.velocity_at(at(0.1)));
  const VelocitySample of_its_own = *sensors_.velocity_at(at(0.1));
  EXPECT_TRUE(near(of_its_own.linear, Eigen::Vector3d(5.2, -0.4, 0.0), 1e-12));
}

TEST_F(MotionSensorsTest, TheGyroAloneTellsTheRotationOfAScan) {
  turn(0.0, 0.12, 0.5);
  const MeasuredMotion found = motion(0.1);
  ASSERT_EQ(found.source, MotionSource::kImu);
  EXPECT_TRUE(near(found.motion.at(0.1), Pose{rotation_about_z(0.05), {0.0, 0.0, 0.0}}, 1e-9));
}

// 2 m to the left of a vehicle that turns left at 0.5 rad/s, a point is 1 m/s slower.
TEST_F(MotionSensorsTest, GyroAndVelocityTellTheMotionOfAPoint) {
  turn(0.0, 0.12, 0.5);
  drive(0.0, 0.12, {10.0, 0.0, 0.0});
  const MeasuredMotion found = motion(0.1, {0.0, 2.0, 0.0});
  ASSERT_EQ(found.source, MotionSource::kImuAndVelocity);
  const double radius = 9.0 / 0.5;
  const Eigen::Vector3d way(radius * std::sin(0.05), radius * (1.0 - std::cos(0.05)), 0.0);
  EXPECT_TRUE(near(found.motion.at(0.1), Pose{rotation_about_z(0.05), way}, 1e-5));
}

TEST_F(MotionSensorsTest, AVelocityAloneTellsTheMotionIfItTurns) {
  drive(0.0, 0.12, {10.0, 0.0, 0.0});
  EXPECT_EQ(motion(0.1).source, MotionSource::kNone) << "it may have no angular part";
  sensors_.clear();
  drive(0.0, 0.12, {10.0, 0.0, 0.0}, 0.5);
  const MeasuredMotion found = motion(0.1);
  ASSERT_EQ(found.source, MotionSource::kVelocity);
  const Eigen::Vector3d way(20.0 * std::sin(0.05), 20.0 * (1.0 - std::cos(0.05)), 0.0);
  EXPECT_TRUE(near(found.motion.at(0.1), Pose{rotation_about_z(0.05), way}, 1e-5));
}

TEST_F(MotionSensorsTest, AScanMayEndShortlyAfterTheLastSample) {
  turn(0.0, 0.1, 0.5);
  EXPECT_EQ(motion(0.115).source, MotionSource::kImu);
  EXPECT_EQ(motion(0.14).source, MotionSource::kNone);
}

// The rates grow, so that they are not taken for the end of the measuring range.
TEST_F(MotionSensorsTest, RatesThatNoVehicleHasAreNotUsedAfterTwentySamples) {
  for (int i = 0; i < 20; ++i) {
    sensors_.add_imu(imu(at(0.01 * i), {0.0, 0.0, 20.0 + 0.1 * i}), "base");
  }
  sensors_.update_until(at(0.18));
  EXPECT_FALSE(sensors_.gyro_is_implausible()) << "19 may be a shock";
  sensors_.update_until(at(0.19));
  EXPECT_TRUE(sensors_.gyro_is_implausible());
  EXPECT_TRUE(sensors_.imu_at(at(0.18))->has_angular_velocity) << "as it was known then";
  EXPECT_FALSE(sensors_.imu_at(at(0.19))->has_angular_velocity);
  sensors_.clear();
  EXPECT_FALSE(sensors_.gyro_is_implausible());
}

TEST_F(MotionSensorsTest, TheBiasOfTheGyroIsTakenOffAfterAStandstill) {
  for (const double speed : {0.0, 10.0}) {
    sensors_.clear();
    turn(0.0, 1.0, 0.01);
    drive(0.0, 1.0, {speed, 0.0, 0.0});
    sensors_.update_until(at(1.0));
    EXPECT_NEAR(sensors_.imu_at(at(0.99))->angular_velocity.z(), 0.01, 1e-12);
    EXPECT_NEAR(sensors_.imu_at(at(1.0))->angular_velocity.z(), speed > 0.0 ? 0.01 : 0.0, 1e-12);
  }
}

// Between its samples the force is linear: its means are 10.5 and 12.5 over the two steps,
// and 10.75 over the second half of the first one.
TEST_F(MotionSensorsTest, TheMeanForceIsThatBetweenTheStamps) {
  const double forces[] = {10.0, 11.0, 14.0};
  for (int i = 0; i < 3; ++i) {
    ImuSample sample = imu(at(0.01 * i));
    sample.linear_acceleration = {1.0, 0.0, forces[i]};
    sensors_.add_imu(sample, "turned");
  }
  const auto whole = sensors_.mean_force_between(at(0.0), at(0.02));
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->since, at(0.0));
  EXPECT_TRUE(near(whole->mean, Eigen::Vector3d(0.0, 1.0, 11.5), 1e-12));
  EXPECT_TRUE(near(whole->p_base_imu, Eigen::Vector3d(2.0, 1.0, 0.0), 1e-12));
  const auto part = sensors_.mean_force_between(at(0.005), at(0.02));
  ASSERT_TRUE(part);
  EXPECT_NEAR(part->mean.z(), (10.75 * 0.005 + 12.5 * 0.01) / 0.015, 1e-9);
  EXPECT_FALSE(sensors_.mean_force_between(at(0.01), at(0.01)));
  EXPECT_FALSE(sensors_.mean_force_between(at(0.0), at(0.03))) << "nothing is known of its end";
}

TEST_F(MotionSensorsTest, TheMeanForceNeedsSamplesAtMostTwentyMillisecondsApart) {
  for (const double t : {0.0, 0.02, 0.05}) sensors_.add_imu(imu(at(t)), "base");
  EXPECT_TRUE(sensors_.mean_force_between(at(0.0), at(0.02)));
  EXPECT_FALSE(sensors_.mean_force_between(at(0.0), at(0.05)));
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
