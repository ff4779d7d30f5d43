// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <GeographicLib/LocalCartesian.hpp>
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

class Samples : public testing::Test {
 protected:
  static DriveOptions options() {
    DriveOptions options;
    options.drive = "tunnel";  // the smallest world
    options.movers = false;
    return options;
  }
  /// Position of a fix in the map frame, m.
  static Eigen::Vector3d to_map(const GnssFix& fix, const GeodeticDatum& datum) {
    const GeographicLib::LocalCartesian geodesy(datum.latitude_deg, datum.longitude_deg,
                                                datum.altitude_m);
    Eigen::Vector3d p;
    geodesy.Forward(fix.latitude_deg, fix.longitude_deg, fix.altitude_m, p.x(), p.y(), p.z());
    return p;
  }
  static Eigen::Vector3d error_of(const Drive& drive, const GnssFix& fix) {
    return to_map(fix, drive.datum()) -
           drive.trajectory().pose(fix.stamp) * drive.mounting().p_base_antenna;
  }
};

TEST_F(Samples, GnssErrorsHaveGivenCovariance) {
  DriveOptions noisy = options();
  noisy.drive = "open_road";
  noisy.gnss_noise = 0.5;
  const Drive drive(noisy);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const GnssFix& fix : drive.gnss()) {
    ASSERT_EQ(fix.status, 2);
    ASSERT_TRUE(fix.covariance);
    squares += error_of(drive, fix).cwiseAbs2().cwiseQuotient(fix.covariance->diagonal());
    ++count;
  }
  ASSERT_GT(count, 900.0);
  // The mean of n squared normal values has a standard deviation of sqrt(2 / n) about 1; four times
  // that are allowed.
  EXPECT_LT((squares / count - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff(),
            4.0 * std::sqrt(2.0 / count));
}

TEST_F(Samples, GnssHasGivenRate) {
  DriveOptions slow = options();
  slow.gnss_rate = 2.0;
  const std::vector<GnssFix> fixes = Drive(slow).gnss();
  ASSERT_GT(fixes.size(), 3U);
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    EXPECT_EQ(fixes[i].stamp - fixes[i - 1].stamp, from_seconds(0.5));
  }
  slow.gnss_rate = 0.0;
  EXPECT_THROW(Drive{slow}, ConfigError);
}

TEST_F(Samples, GnssHasNoFixInOutagesAndTunnels) {
  DriveOptions with_outage = options();
  with_outage.gnss_outages = {{2.0, 4.0}};
  const Drive drive(with_outage);
  int lost_in_outage = 0, lost_later = 0;
  for (const GnssFix& fix : drive.gnss()) {
    const double seconds = to_seconds(fix.stamp - drive.trajectory().begin());
    const bool in_outage = seconds >= 2.0 && seconds < 4.0;
    if (in_outage) {
      EXPECT_EQ(fix.status, -1);
    }
    if (fix.status >= 0) continue;
    EXPECT_FALSE(fix.covariance);
    EXPECT_TRUE(std::isnan(fix.latitude_deg));
    (in_outage ? lost_in_outage : lost_later) += 1;
  }
  EXPECT_EQ(lost_in_outage, 20);
  EXPECT_GT(lost_later, 100);  // the tube
}

TEST_F(Samples, GnssJumpsByGivenDistanceWithUnchangedCovariance) {
  DriveOptions with_jump = options();
  with_jump.gnss_jumps = {{3.0, 8.0}};
  const Drive drive(with_jump);
  const std::vector<GnssFix> fixes = drive.gnss();
  EXPECT_TRUE(test::near(error_of(drive, fixes[20]), Eigen::Vector3d::Zero(), 0.2));
  EXPECT_NEAR(error_of(drive, fixes[40]).norm(), 8.0, 0.2);
  EXPECT_EQ(*fixes[20].covariance, *fixes[40].covariance);
}

TEST_F(Samples, ImuMeasuresRatesAndSpecificForceInItsOwnAxes) {
  const Drive drive(options());
  const auto imu = drive.imu();
  for (std::size_t i = 0; i < imu.size(); i += 97) {
    const MotionState state =
        drive.trajectory().state(imu[i].stamp).of_frame(drive.mounting().T_base_imu);
    const Eigen::Vector3d force = state.T_map_base.rotation.conjugate() *
                                  (state.acceleration_map + Eigen::Vector3d(0, 0, kGravity));
    EXPECT_TRUE(test::near(imu[i].angular_velocity, state.angular_velocity_base,
                           5.0 * (kGyroNoise + kGyroBias)));
    EXPECT_TRUE(test::near(imu[i].linear_acceleration, force,
                           5.0 * (kAccelerometerNoise + kAccelerometerBias)));
    EXPECT_LT(rotation_angle(imu[i].orientation->conjugate() * state.T_map_base.rotation),
              6.0 * kOrientationNoise);
  }
}

TEST_F(Samples, ImuAtRestMeasuresGravityUpwards) {
  const Drive drive(options());
  EXPECT_NEAR(drive.imu().front().linear_acceleration.z(), kGravity, 0.3);
}

TEST_F(Samples, IntegratedRatesGiveRotationOfTrajectory) {
  const Drive drive(options());
  const auto imu = drive.imu();
  const Pose& T_base_imu = drive.mounting().T_base_imu;
  Eigen::Quaterniond R = (drive.trajectory().pose(imu[0].stamp) * T_base_imu).rotation;
  for (std::size_t i = 0; i + 1 < imu.size(); ++i) {
    const Eigen::Vector3d rate = 0.5 * (imu[i].angular_velocity + imu[i + 1].angular_velocity);
    R = (R * exp_so3(0.01 * rate)).normalized();
  }
  const Pose last = drive.trajectory().pose(imu.back().stamp) * T_base_imu;
  const double seconds = 0.01 * static_cast<double>(imu.size());
  EXPECT_LT(rotation_angle(R.conjugate() * last.rotation), 4.0 * kGyroBias * seconds);
}

TEST_F(Samples, VelocityIsThatOfTheImuFrame) {
  const Drive drive(options());
  const auto velocity = drive.velocity();
  for (std::size_t i = 0; i < velocity.size(); i += 89) {
    const MotionState state =
        drive.trajectory().state(velocity[i].stamp).of_frame(drive.mounting().T_base_imu);
    EXPECT_TRUE(test::near(state.T_map_base.rotation * velocity[i].linear, state.velocity_map,
                           6.0 * kVelocityNoise));
  }
}

TEST_F(Samples, CoverAllScansOfACutDrive) {
  DriveOptions cut = options();
  cut.duration = 5.0;
  const Drive drive(cut);
  ASSERT_GT(drive.scan_count(), 40U);
  const Stamp last = drive.scan_stamp(drive.scan_count() - 1);
  EXPECT_LT(drive.imu().front().stamp, drive.scan_stamp(0));
  EXPECT_GE(drive.imu().back().stamp, last + 100'000'000);
  EXPECT_LE(drive.imu().back().stamp, drive.trajectory().begin() + 5'000'000'000);
  EXPECT_GE(drive.gnss().back().stamp, last);
}

TEST_F(Samples, BeginAtStartOfCutDrive) {
  DriveOptions cut = options();
  cut.start = 2.0;
  cut.duration = 5.0;
  const Drive drive(cut);
  const Stamp start = drive.trajectory().begin() + 2'000'000'000;
  EXPECT_GT(drive.scan_stamp(0), start);
  EXPECT_LT(drive.scan_stamp(0), start + 300'000'000);
  EXPECT_GE(drive.imu().front().stamp, start);
  EXPECT_LT(drive.imu().front().stamp, drive.scan_stamp(0));
  EXPECT_LE(drive.scan_stamp(drive.scan_count() - 1), start + 3'000'000'000);
}

TEST_F(Samples, EmptyDriveIsAnError) {
  DriveOptions cut = options();
  cut.start = 5.0;
  cut.duration = 5.0;
  EXPECT_THROW(Drive{cut}, ConfigError);
}

}  // namespace
}  // namespace lidar_mapping::simulation
