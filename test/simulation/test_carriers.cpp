// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <gtest/gtest.h>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

constexpr Stamp kImuPeriod = 5'000'000;

const Drive& drive_of(const std::string& name) {
  static std::map<std::string, std::unique_ptr<Drive>> built;
  std::unique_ptr<Drive>& drive = built[name];
  if (!drive) {
    DriveOptions options;
    options.drive = name;
    options.lidar = "vlp16";
    options.range_noise = 0.0;
    options.undistorted = true;
    options.imu = "ideal";
    drive = std::make_unique<Drive>(options);
  }
  return *drive;
}

std::vector<MotionState> states_of(const Drive& drive) {
  const SmoothTrajectory& trajectory = drive.trajectory();
  std::vector<MotionState> states;
  for (Stamp t = trajectory.begin(); t <= trajectory.end(); t += kImuPeriod)
    states.push_back(trajectory.state(t));
  return states;
}

/// Integrates ideal samples over a second from each tenth second on (Simpson's rule over pairs of
/// intervals) and compares the result with the trajectory.
class EveryCarrier : public testing::TestWithParam<const char*> {};

TEST_P(EveryCarrier, ImuSamplesIntegrateToTrajectory) {
  const Drive& drive = drive_of(GetParam());
  const std::vector<ImuSample> imu = drive.imu();
  ASSERT_EQ(imu[1].stamp - imu[0].stamp, kImuPeriod);
  const Pose& T_base_imu = drive.mounting().T_base_imu;
  const Eigen::Vector3d gravity(0.0, 0.0, -kGravity);
  const double h = 2.0 * to_seconds(kImuPeriod);
  for (std::size_t first = 0; first + 200 < imu.size(); first += 2000) {
    MotionState state = drive.trajectory().state(imu[first].stamp).of_frame(T_base_imu);
    Eigen::Quaterniond R = state.T_map_base.rotation;
    Eigen::Vector3d v = state.velocity_map, p = state.T_map_base.translation;
    for (std::size_t i = first; i < first + 200; i += 2) {
      const auto w = [&](std::size_t k) { return imu[i + k].angular_velocity; };
      const auto a = [&](std::size_t k) { return imu[i + k].linear_acceleration; };
      const Eigen::Quaterniond to_middle = exp_so3(h / 24.0 * (5.0 * w(0) + 8.0 * w(1) - w(2)));
      const Eigen::Quaterniond to_end = exp_so3(h / 6.0 * (w(0) + 4.0 * w(1) + w(2)));
      const Eigen::Vector3d begin = R * a(0) + gravity, middle = R * (to_middle * a(1)) + gravity,
                            end = R * (to_end * a(2)) + gravity;
      p += h * v + h * h / 6.0 * (begin + 2.0 * middle);
      v += h / 6.0 * (begin + 4.0 * middle + end);
      R = (R * to_end).normalized();
    }
    state = drive.trajectory().state(imu[first + 200].stamp).of_frame(T_base_imu);
    EXPECT_LT(rotation_angle(R.conjugate() * state.T_map_base.rotation), 1e-3) << first;
    EXPECT_TRUE(test::near(p, state.T_map_base.translation, 5e-3)) << first;
    EXPECT_TRUE(test::near(v, state.velocity_map, 1e-2)) << first;
  }
}

INSTANTIATE_TEST_SUITE_P(Carriers, EveryCarrier,
                         testing::Values("handheld", "handheld_forest", "running", "running_forest",
                                         "spin", "stairs", "legged", "legged_forest", "drone",
                                         "elevator"),
                         [](const auto& drive) { return drive.param; });

TEST(Carriers, LeggedRobotHasShocksOfThreeG) {
  std::vector<double> peaks;
  double peak = 0.0;
  // A peak ends when the body falls again.
  for (const MotionState& state : states_of(drive_of("legged"))) {
    const double upwards = state.acceleration_map.z();
    if (upwards <= 0.0 && peak > 10.0) peaks.push_back(peak);
    peak = upwards <= 0.0 ? 0.0 : std::max(peak, upwards);
  }
  ASSERT_GT(peaks.size(), 200U);
  EXPECT_NEAR(median(peaks) / kGravity, 3.0, 0.3);
}

TEST(Carriers, SpinDriveTurnsAtFiveRadiansPerSecond) {
  double fastest = 0.0, turned_angle = 0.0;
  for (const MotionState& state : states_of(drive_of("spin"))) {
    const double rate = state.angular_velocity_base.norm();
    fastest = std::max(fastest, rate);
    if (rate > 4.0) turned_angle += rate * to_seconds(kImuPeriod);
  }
  EXPECT_NEAR(fastest, 5.0, 0.8);
  EXPECT_GT(turned_angle, 20.0);
}

TEST(Carriers, DroneTiltsInFlightAndRestsAtTheBeginning) {
  const std::vector<MotionState> states = states_of(drive_of("drone"));
  const auto tilt = [](const MotionState& state) {
    return std::acos((state.T_map_base.rotation * Eigen::Vector3d::UnitZ()).z()) * kDegPerRad;
  };
  double largest_tilt = 0.0;
  for (const MotionState& state : states) largest_tilt = std::max(largest_tilt, tilt(state));
  EXPECT_GT(largest_tilt, 35.0);
  EXPECT_LT(largest_tilt, 75.0);
  EXPECT_LT(tilt(states.front()), 0.1);
  EXPECT_TRUE(test::near(states.front().velocity_map, Eigen::Vector3d::Zero(), 1e-3));
}

TEST(Carriers, StairsDriveVisitsThreeStoreys) {
  std::vector<double> heights;
  for (const MotionState& state : states_of(drive_of("stairs"))) {
    heights.push_back(state.T_map_base.translation.z());
  }
  const double highest = *std::max_element(heights.begin(), heights.end());
  EXPECT_NEAR(highest - heights.front(), 9.6, 0.1);
  EXPECT_NEAR(heights.back(), heights.front(), 0.1);
}

/// Index of the first scan at which the lift moves at its full speed.
std::size_t scan_in_moving_lift(const Drive& drive) {
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const double speed = drive.trajectory().state(drive.scan_stamp(i)).velocity_map.z();
    const bool keeps_speed =
        i + 5 < drive.scan_count() &&
        drive.trajectory().state(drive.scan_stamp(i + 5)).velocity_map.z() > 1.55;
    if (speed > 1.55 && keeps_speed) return i;
  }
  return 0;
}

TEST(Carriers, OnlyTheImuObservesTheMotionOfTheLift) {
  DriveOptions options;
  options.drive = "elevator";
  options.lidar = "os0";
  options.range_noise = 0.0;
  options.undistorted = true;
  const Drive drive(options);
  const std::size_t at = scan_in_moving_lift(drive);
  ASSERT_GT(at, 30U);
  // Every ray ends in the car.
  const SimulatedScan scan = drive.scan(at);
  ASSERT_GT(scan.cloud.size(), 50'000U);
  const auto points_of_car = std::count(scan.moving.begin(), scan.moving.end(), 1);
  EXPECT_GT(static_cast<double>(points_of_car), 0.999 * static_cast<double>(scan.cloud.size()));
  // The ceiling of the car moves with the sensor.
  const auto ceiling_above = [&](std::size_t index) {
    const Pose T_map_base = drive.trajectory().pose(drive.scan_stamp(index));
    const Pose T_map_lidar = T_map_base * drive.mounting().T_base_lidar;
    double highest = -1e9;
    for (const Point& p : drive.scan(index).cloud.points) {
      highest = std::max(highest, (T_map_lidar * p.position().cast<double>()).z());
    }
    return highest - T_map_base.translation.z();
  };
  EXPECT_NEAR(ceiling_above(at), 2.25 - 1.2, 0.01);
  EXPECT_NEAR(ceiling_above(at), ceiling_above(at + 5), 0.005);
  double largest_acceleration = 0.0;
  for (const MotionState& state : states_of(drive)) {
    if (std::abs(state.velocity_map.z()) > 0.3) {
      largest_acceleration = std::max(largest_acceleration, std::abs(state.acceleration_map.z()));
    }
  }
  EXPECT_GT(largest_acceleration, 0.6);
}

}  // namespace
}  // namespace lidar_mapping::simulation
