// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// First instant of every drive, ns.
constexpr Stamp kDriveBegin = 1'317'384'506'417'322'000;

/// Periods of the IMU on a car and on other carriers, ns.
constexpr Stamp kDefaultImuPeriod = 10'000'000;
constexpr Stamp kCarrierImuPeriod = 5'000'000;

/// A world, the motion through it and the mounting of the sensors.
struct Scenario {
  World world;
  SmoothTrajectory trajectory;
  SensorMounting mounting;
  std::vector<GnssOutage> covered;  ///< Intervals in which no satellite is in view.
  Stamp imu_period = kDefaultImuPeriod;
  /// Objects nearer than the least range of the LiDAR occlude what is behind them. Older drives
  /// ignore such objects, so that their scans stay the same.
  bool near_objects_occlude = false;
};

/// The scenario of a carrier other than a car or `walk`, still without a world.
inline Scenario carrier_scenario(SmoothTrajectory trajectory, const SensorMounting& mounting,
                                 std::vector<GnssOutage> covered) {
  return {{}, std::move(trajectory), mounting, std::move(covered), kCarrierImuPeriod, true};
}

/// Seed of everything that differs between passes.
inline std::uint64_t day_seed(const DriveOptions& options, std::uint64_t seed) {
  return options.pass == 0 ? seed : mix64(seed ^ mix64(options.pass));
}

Scenario make_town(const DriveOptions& options);
Scenario make_figure_eight(const DriveOptions& options);
Scenario make_twins(const DriveOptions& options);
Scenario make_city(const DriveOptions& options);
Scenario make_open_road(const DriveOptions& options);
Scenario make_tunnel(const DriveOptions& options);
Scenario make_car_park(const DriveOptions& options);
Scenario make_walk(const DriveOptions& options);
Scenario make_handheld(const DriveOptions& options);
Scenario make_running(const DriveOptions& options);
Scenario make_spin(const DriveOptions& options);
Scenario make_legged(const DriveOptions& options);
Scenario make_handheld_forest(const DriveOptions& options);
Scenario make_running_forest(const DriveOptions& options);
Scenario make_legged_forest(const DriveOptions& options);
Scenario make_drone(const DriveOptions& options);
Scenario make_stairs(const DriveOptions& options);
Scenario make_elevator(const DriveOptions& options);

}  // namespace lidar_mapping::simulation
