// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/simulation/drive.hpp"

#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

/// Figures that identify a scan. A seed has to give the same scans in all versions, because
/// otherwise published figures could not be reproduced. A processor without AVX2 may round a ray
/// into or out of an edge, so that sums are compared and not bytes.
struct Figures {
  std::size_t points, moving;
  Eigen::Vector3d mean;
  double intensity;
};

void expect_figures(const SimulatedScan& scan, const Figures& expected) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double intensity = 0.0;
  std::size_t moving = 0;
  const auto count = static_cast<double>(scan.cloud.size());
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    mean += scan.cloud.points[i].position().cast<double>() / count;
    intensity += scan.cloud.points[i].intensity / count;
    moving += scan.moving[i];
  }
  EXPECT_NEAR(count, static_cast<double>(expected.points), 3.0);
  EXPECT_NEAR(static_cast<double>(moving), static_cast<double>(expected.moving), 3.0);
  EXPECT_TRUE(test::near(mean, expected.mean, 5e-3)) << mean.transpose();
  EXPECT_NEAR(intensity, expected.intensity, 0.02);
}

TEST(OldSeeds, GiveTheSameTown) {
  DriveOptions options;
  options.seed = 13;
  options.duration = 2.5;
  expect_figures(Drive(options).scan(10),
                 {108453, 745, {-0.657247, 0.506423, -1.246867}, 45.564023});
}

TEST(OldSeeds, GiveTheSameWalkAndImuSamples) {
  DriveOptions options;
  options.drive = "walk";
  options.lidar = "vlp16";
  options.seed = 5;
  options.duration = 8.0;
  const Drive drive(options);
  expect_figures(drive.scan(40), {28526, 191, {0.437562, -0.352961, -0.016860}, 116.387716});
  const std::vector<ImuSample> imu = drive.imu();
  ASSERT_EQ(imu.size(), 801U);
  const Eigen::Vector3d rate(0.17727309290497076, 0.08374328897687072, -0.09623276358406438);
  const Eigen::Vector3d force(-0.3368959057981154, -0.3904710788866114, 8.370486204815816);
  EXPECT_TRUE(test::near(imu[500].angular_velocity, rate, 1e-9));
  EXPECT_TRUE(test::near(imu[500].linear_acceleration, force, 1e-9));
}

TEST(OldSeeds, GiveTheSameFaultyScans) {
  DriveOptions options;
  options.drive = "tunnel";
  options.lidar = "os1_64";
  options.seed = 7;
  options.duration = 3.0;
  for (const char* fault : {"outliers=0.2", "rain=0.1", "wall", "sparse=3000"}) {
    add_fault(options, fault);
  }
  const SimulatedScan scan = Drive(options).scan(10);
  EXPECT_EQ(scan.cloud.size(), 3000U);
  // One ray more or less changes the random choice of all points after it.
  std::size_t moving = 0;
  for (const std::uint8_t m : scan.moving) moving += m;
  EXPECT_NEAR(static_cast<double>(moving), 2042.0, 60.0);
}

}  // namespace
}  // namespace lidar_mapping::simulation
