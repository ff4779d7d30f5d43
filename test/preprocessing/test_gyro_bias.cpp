// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "motion/gyro_bias.hpp"
#include "near.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::near;

/// An IMU at 100 Hz on a vehicle whose state does not change.
class Imu {
 public:
  GyroBias bias;

  /// Adds samples for this time, s, whose rates vary by `vibration` (rad/s) about `rate`.
  void add(double seconds, const Eigen::Vector3d& rate, std::optional<bool> standing,
           double vibration = 0.0, double shaking = 0.0) {
    const Stamp end = stamp_ + from_seconds(seconds);
    for (; stamp_ < end; stamp_ += period_) {
      const double sign = (stamp_ / period_) % 2 == 0 ? 1.0 : -1.0;
      ImuSample sample;
      sample.stamp = stamp_;
      sample.angular_velocity = rate + sign * vibration * Eigen::Vector3d::Ones();
      sample.linear_acceleration =
          Eigen::Vector3d(0.0, 0.0, kStandardGravity) + sign * shaking * Eigen::Vector3d::Ones();
      bias.add(sample, standing);
    }
  }
  void set_period(double seconds) { period_ = from_seconds(seconds); }
  void jump(double seconds) { stamp_ += from_seconds(seconds); }
  Eigen::Vector3d now() const { return bias.at(stamp_); }

 private:
  Stamp stamp_ = from_seconds(100.0);
  Stamp period_ = from_seconds(0.01);
};

const Eigen::Vector3d kBias(0.01, -0.005, 0.003);

TEST(GyroBias, IsFoundInASecondOfStandstill) {
  Imu imu;
  imu.add(0.9, kBias, std::nullopt);
  EXPECT_EQ(imu.now(), Eigen::Vector3d::Zero());
  imu.add(0.2, kBias, std::nullopt);
  EXPECT_TRUE(near(imu.now(), kBias, 1e-12));
}

TEST(GyroBias, IsNotThatOfAMovingVehicle) {
  const auto found = [](std::optional<bool> standing, double vibration, double shaking) {
    Imu imu;
    imu.add(3.0, kBias, standing, vibration, shaking);
    return imu.now() != Eigen::Vector3d::Zero();
  };
  EXPECT_FALSE(found(false, 0.0, 0.0)) << "the velocity says that it moves";
  EXPECT_FALSE(found(std::nullopt, 0.015, 0.0)) << "its rates vary";
  EXPECT_FALSE(found(std::nullopt, 0.0, 0.2)) << "its accelerations vary";
  EXPECT_TRUE(found(std::nullopt, 0.005, 0.1)) << "an engine runs";
}

/// Without a velocity a slow bend looks like a bias.
TEST(GyroBias, MayBeLargerWhereAVelocityConfirmsTheStandstill) {
  const Eigen::Vector3d large(0.0, 0.0, 0.04);
  Imu imu;
  imu.add(1.5, large, std::nullopt);
  EXPECT_EQ(imu.now(), Eigen::Vector3d::Zero());
  imu.add(2.5, large, true);
  EXPECT_TRUE(near(imu.now(), large, 1e-12));
  Imu faster;
  faster.add(3.0, {0.0, 0.0, 0.06}, true);
  EXPECT_EQ(faster.now(), Eigen::Vector3d::Zero());
}

TEST(GyroBias, FollowsAChangeByAQuarter) {
  Imu imu;
  imu.add(1.01, kBias, true);
  imu.add(1.01, 2.0 * kBias, true);
  EXPECT_TRUE(near(imu.now(), 1.25 * kBias, 1e-12));
}

TEST(GyroBias, DependsOnNoLaterSample) {
  Imu imu;
  imu.add(1.01, kBias, true);
  const Stamp then = from_seconds(101.0);
  const Eigen::Vector3d before = imu.bias.at(then);
  imu.add(5.0, 2.0 * kBias, true);
  EXPECT_EQ(imu.bias.at(then), before);
  EXPECT_EQ(imu.bias.at(then - 1), Eigen::Vector3d::Zero()) << "nothing was known yet";
}

TEST(GyroBias, NeedsSomeSamplesOfTheSameTime) {
  Imu sparse;
  sparse.set_period(0.2);
  sparse.add(5.0, kBias, true);
  EXPECT_EQ(sparse.now(), Eigen::Vector3d::Zero()) << "six samples a second";
  Imu reset;
  reset.add(0.6, kBias, true);
  reset.jump(-0.1);
  reset.add(0.6, kBias, true);
  EXPECT_EQ(reset.now(), Eigen::Vector3d::Zero()) << "no second since the time went back";
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
