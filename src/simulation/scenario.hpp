// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// First instant of every drive.
constexpr Stamp kDriveBegin = 1'317'384'506'417'322'000;

/// Between samples of the IMU.
constexpr Stamp kUsualImuPeriod = 10'000'000;
constexpr Stamp kCarrierImuPeriod = 5'000'000;

/// A world and the way through it.
struct Scenario {
  World world;
  SmoothTrajectory trajectory;
  SensorMounting mounting;
  std::vector<GnssOutage> covered;  ///< where no satellite is in view
  Stamp imu_period = kUsualImuPeriod;
  /// What is nearer than the LiDAR can measure hides what is behind it. Older drives look through
  /// it and stay as they were.
  bool near_things_hide = false;
};

/// The seed of what is another on another day.
inline std::uint64_t day_seed(const DriveOptions& options, std::uint64_t seed) {
  return options.pass == 0 ? seed : mixed(seed ^ mixed(options.pass));
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
