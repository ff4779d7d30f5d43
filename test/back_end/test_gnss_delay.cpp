// SPDX-License-Identifier: BSD-3-Clause

#include "back_end_fixture.hpp"
#include "gnss/gnss_delay.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::feed;
using test::optimize;
using test::SyntheticDrive;

constexpr double kPeriod = 0.1;  // s between key frames

/// The fix at key frame `at` of a receiver whose stamps are `delay` seconds late.
GnssPosition late_fix(const SyntheticDrive& drive, int at, double delay, std::mt19937& engine) {
  GnssPosition fix = test::make_gnss(drive, at, engine, 0.02);
  const auto pose = [&](double place) {
    const auto before = static_cast<std::size_t>(std::max(0.0, std::floor(place)));
    const std::size_t after = std::min(before + 1, drive.truth.size() - 1);
    return interpolate(drive.truth[before], drive.truth[after],
                       place - static_cast<double>(before));
  };
  fix.p_enu_antenna +=
      pose(at - delay / kPeriod) * fix.p_base_antenna - pose(at) * fix.p_base_antenna;
  return fix;
}

/// RMS error of the positions with their delay in the lever arm, relative to the true antenna, m.
double misfit(const std::vector<GnssPosition>& positions, const SyntheticDrive& drive,
              std::size_t first, std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = first; i < first + count; ++i) {
    const Eigen::Vector3d error =
        drive.truth[i] * positions[i].p_base_antenna - positions[i].p_enu_antenna;
    sum += error.head<2>().squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

void add_fixes(BackEnd& back_end, const SyntheticDrive& drive, double delay, int first, int end) {
  std::mt19937 engine(5);
  for (int i = first; i < end; ++i) back_end.add_gnss(late_fix(drive, i, delay, engine));
}

TEST(GnssDelay, IsCorrectedFromTheFirstFixOn) {
  const SyntheticDrive drive = test::make_drive();
  const int size = static_cast<int>(drive.truth.size());
  for (const double delay : {-0.05, 0.05}) {
    BackEnd back_end(BackEndConfig{});
    feed(back_end, drive);
    add_fixes(back_end, drive, delay, 0, size - 1);
    EXPECT_GT(misfit(back_end.positions(), drive, 1, 50), 0.4);
    optimize(back_end, true);
    // The noise of the fixes is 3 cm.
    EXPECT_LT(misfit(back_end.positions(), drive, 1, 50), 0.06) << delay;
    EXPECT_LT(misfit(back_end.positions(), drive, 400, 350), 0.06) << delay;
    EXPECT_LT(test::true_rmse(back_end, drive), 0.06) << delay;
  }
}

TEST(GnssDelay, IsNotEstimatedIfSwitchedOff) {
  const SyntheticDrive drive = test::make_drive();
  BackEndConfig config;
  config.estimate_gnss_time_offset = false;
  BackEnd back_end(config);
  feed(back_end, drive);
  add_fixes(back_end, drive, 0.05, 0, 700);
  optimize(back_end, true);
  EXPECT_GT(test::true_rmse(back_end, drive), 0.3);
  std::mt19937 engine(5);
  const GnssPosition given = late_fix(drive, 0, 0.05, engine);
  EXPECT_TRUE(back_end.positions()[0].p_base_antenna.isApprox(given.p_base_antenna, 1e-12));
  EXPECT_TRUE(back_end.positions()[0].covariance.isApprox(given.covariance, 1e-12));
}

TEST(GnssDelay, IsZeroForCorrectStamps) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  add_fixes(back_end, drive, 0.0, 0, 700);
  optimize(back_end, true);
  const Eigen::Vector3d arm(0.5, 0.2, 1.5);
  for (const GnssPosition& position : back_end.positions()) {
    ASSERT_TRUE(position.p_base_antenna.isApprox(arm, 1e-12));
  }
}

TEST(GnssDelay, IncreasesTheCovarianceWhileUnknown) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  for (std::size_t i = 0; i < 40; ++i) back_end.add_key_frame(drive.key_frames[i]);
  add_fixes(back_end, drive, 0.0, 0, 40);
  optimize(back_end);
  // The street leads east: 50 ms at 10 m/s along the street, no effect across it.
  const Eigen::Matrix3d covariance = back_end.positions()[20].covariance;
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.5, 0.05);
  EXPECT_LT(std::sqrt(covariance(1, 1)), 0.05);
}

/// A round course with bends of 20 m radius at 3 to 11 m/s.
Pose pose_in_traffic(double seconds) {
  const double turned = (7.0 * seconds - 4.0 / 1.1 * std::cos(1.1 * seconds)) / 20.0;
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitZ())),
          20.0 * Eigen::Vector3d(std::sin(turned), 1.0 - std::cos(turned), 0.0)};
}

TEST(GnssDelay, UsesThePathOfTheAntennaAtChangingSpeed) {
  constexpr double kStep = 0.3;  // s
  const Eigen::Vector3d arm(-1.0, 0.4, 1.5);
  DriveGraph drive;
  drive.in_enu = {true};
  for (int i = 0; i < 100; ++i) {
    DriveNode node;
    node.stamp = from_seconds(kStep * i);
    node.connected = i > 0;
    node.T_odom_base = pose_in_traffic(kStep * i);
    drive.nodes.push_back(node);
  }
  for (const double delay : {-0.05, 0.05, 0.2}) {
    drive.gnss_delays = {{delay, 0.003, Eigen::Vector2d::Zero()}};
    for (int i = 2; i < 98; ++i) {
      DriveGnss gnss;
      gnss.node = i;
      gnss.position.p_base_antenna = arm;
      const Eigen::Vector3d then =
          pose_in_traffic(kStep * i).inverse() * (pose_in_traffic(kStep * i - delay) * arm);
      ASSERT_TRUE(test::near(delay_corrected_position(drive, gnss).p_base_antenna, then, 0.004))
          << delay;
      const Eigen::Vector3d velocity = antenna_velocity(drive, gnss);
      const Eigen::Vector3d soon =
          pose_in_traffic(kStep * i).inverse() * (pose_in_traffic(kStep * i - delay + 1e-4) * arm);
      ASSERT_TRUE(test::near(velocity, (soon - then) / 1e-4, 0.1)) << delay;
    }
  }
}

TEST(GnssDelay, IsEstimatedDuringTheDrivePerSegment) {
  SyntheticDrive drive = test::make_drive();
  for (std::size_t i = 400; i < drive.key_frames.size(); ++i) drive.key_frames[i].segment = 1;
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  for (int i = 0; i < 800; ++i) {
    back_end.add_key_frame(drive.key_frames[i]);
    back_end.add_gnss(late_fix(drive, i, i < 400 ? 0.05 : 0.0, engine));
    if (i % 100 == 99) optimize(back_end);
  }
  EXPECT_LT(misfit(back_end.positions(), drive, 1, 50), 0.06);
  EXPECT_LT(misfit(back_end.positions(), drive, 400, 399), 0.06);
}

}  // namespace
}  // namespace lidar_mapping::back_end
