// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "back_end_fixture.hpp"
#include "imu/tilt_scatter.hpp"
#include "imu/vertical.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {
namespace {

/// Error of the IMU's orientation at a key frame, about the axes of the map (deg).
using TiltError = std::function<Eigen::Vector3d(std::size_t)>;

/// The vehicle makes a full turn in 100 key frames.
double heading(std::size_t i) { return 0.02 * M_PI * static_cast<double>(i); }

/// A drive of this vehicle with one loop and perfect odometry, with a frame of its own per segment.
DriveGraph round_drive(std::size_t count, const TiltError& error, std::size_t segments = 1) {
  DriveGraph drive;
  drive.in_enu.assign(segments, false);
  drive.loops.emplace_back();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Quaterniond R_map_base = exp_so3({0.0, 0.0, heading(i)});
    DriveNode node;
    node.segment = static_cast<int>(i * segments / count);
    node.T_odom_base.rotation = exp_so3({0.5 * node.segment, 0.2, 0.1}) * R_map_base;
    DriveImu imu;
    imu.node = static_cast<int>(i);
    imu.sample.orientation = exp_so3(kRadPerDeg * error(i)) * R_map_base;
    drive.nodes.push_back(node);
    drive.imu.push_back(imu);
  }
  return drive;
}

/// Errors of `sigma` about x and y with a correlation length of `length` key frames; 0:
/// independent.
TiltError noise(double sigma, double length) {
  auto engine = std::make_shared<std::mt19937>(4);
  auto state = std::make_shared<Eigen::Vector3d>(Eigen::Vector3d::Zero());
  const double correlation = length == 0.0 ? 0.0 : std::exp(-1.0 / length);
  return [=](std::size_t) {
    std::normal_distribution<double> normal(0.0,
                                            sigma * std::sqrt(1.0 - correlation * correlation));
    const double x = normal(*engine), y = normal(*engine);
    *state = correlation * *state + Eigen::Vector3d(x, y, 0.0);
    return *state;
  };
}

double stddev_deg(const DriveGraph& drive, const BackEndConfig& config) {
  return tilt_stddev(drive, config) / kRadPerDeg;
}

TEST(TiltScatter, OfIndependentErrorsIsTheirStandardDeviation) {
  const double stddev = stddev_deg(round_drive(1000, noise(0.8, 0.0)), {});
  EXPECT_GT(stddev, 0.75);
  EXPECT_LT(stddev, 1.2);  // the largest of several estimates
  const double in_segments = stddev_deg(round_drive(1000, noise(0.8, 0.0), 3), {});
  EXPECT_NEAR(in_segments, stddev, 0.2);
}

TEST(TiltScatter, IncludesErrorsThatNeighboursHaveInCommon) {
  // The mean of n key frames has the variance 40 / n times 0.3^2; means of finite length show only
  // a part of it.
  const double honest = 0.3 * std::sqrt(2.0 * 20.0);
  const double stddev = stddev_deg(round_drive(2000, noise(0.3, 20.0)), {});
  EXPECT_GT(stddev, 0.7 * honest);
  EXPECT_LT(stddev, 1.3 * honest);
}

TEST(TiltScatter, IncludesAMountingErrorOfTheImu) {
  const BackEndConfig config;
  const auto aslant = [](std::size_t i) {
    return Eigen::Vector3d(std::cos(heading(i)), std::sin(heading(i)), 0.0);
  };
  EXPECT_DOUBLE_EQ(tilt_stddev(round_drive(1000, aslant), config), config.imu_orientation_stddev);
}

TEST(TiltScatter, HasALowerBound) {
  const BackEndConfig config;
  const auto nothing = [](std::size_t) { return Eigen::Vector3d(0.0, 0.0, 0.0); };
  EXPECT_DOUBLE_EQ(tilt_stddev(round_drive(1000, nothing), config),
                   0.25 * config.imu_orientation_stddev);
}

TEST(TiltScatter, IsAsConfiguredIfOnlyOdometryDeterminesTheHeight) {
  BackEndConfig config;
  DriveGraph drive = round_drive(1000, noise(0.8, 0.0));
  drive.loops.front().evaluated = true;  // evaluated and not used
  EXPECT_DOUBLE_EQ(tilt_stddev(drive, config), config.imu_orientation_stddev);
  drive.gnss.emplace_back();
  EXPECT_LT(stddev_deg(drive, config), 1.2);
  config.georeference_only = true;
  EXPECT_DOUBLE_EQ(tilt_stddev(drive, config), config.imu_orientation_stddev);
}

TEST(TiltScatter, WeightsTheTiltWithoutChangingTheParameter) {
  const BackEndConfig config;
  DriveGraph drive = round_drive(1, noise(0.8, 0.0));
  EXPECT_NEAR(verticals(drive, config).front().stddev, 2.0 * kRadPerDeg, 1e-12);
  drive.tilt_stddev = 0.7 * kRadPerDeg;
  EXPECT_NEAR(verticals(drive, config).front().stddev, 0.7 * kRadPerDeg, 1e-12);

  const test::SyntheticDrive laps = test::make_drive();
  BackEnd back_end(config);
  std::mt19937 engine(3);
  for (std::size_t i = 0; i < laps.truth.size(); ++i) {
    back_end.add_key_frame(laps.key_frames[i]);
    ImuSample sample;
    sample.stamp = laps.key_frames[i].stamp;
    sample.orientation = laps.key_frames[i].T_odom_base.rotation;
    back_end.add_imu(sample);
  }
  test::add_lap_loops(back_end, laps, 400, 5, engine);
  const auto problem = back_end.problem(true);
  EXPECT_EQ(problem->config.imu_orientation_stddev, config.imu_orientation_stddev);
  ASSERT_TRUE(problem->drive.tilt_stddev);
  EXPECT_LT(*problem->drive.tilt_stddev, config.imu_orientation_stddev);
}

TEST(TiltScatter, IsAsConfiguredOnAStraightRoad) {
  const BackEndConfig config;
  DriveGraph drive = round_drive(1000, noise(0.8, 0.0));
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    const Eigen::Quaterniond undone = exp_so3({0.0, 0.0, -heading(i)});
    drive.nodes[i].T_odom_base.rotation *= undone;
    *drive.imu[i].sample.orientation *= undone;
  }
  EXPECT_DOUBLE_EQ(tilt_stddev(drive, config), config.imu_orientation_stddev);
}

TEST(TiltScatter, IsAsConfiguredForShortDrives) {
  const BackEndConfig config;
  EXPECT_DOUBLE_EQ(tilt_stddev(round_drive(100, noise(0.1, 0.0)), config),
                   config.imu_orientation_stddev);
  EXPECT_DOUBLE_EQ(tilt_stddev({}, config), config.imu_orientation_stddev);
}

}  // namespace
}  // namespace lidar_mapping::back_end
