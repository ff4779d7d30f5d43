#pragma once

#include <vector>

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::simulation {

/// First instant of every drive.
constexpr Stamp kDriveBegin = 1'317'384'506'417'322'000;

/// A world and the way through it.
struct Scenario {
  World world;
  SmoothTrajectory trajectory;
  SensorMounting mounting;
  std::vector<GnssOutage> covered;  ///< where no satellite is in view
};

Scenario make_town(const DriveOptions& options);
Scenario make_figure_eight(const DriveOptions& options);
Scenario make_twins(const DriveOptions& options);
Scenario make_city(const DriveOptions& options);
Scenario make_open_road(const DriveOptions& options);
Scenario make_tunnel(const DriveOptions& options);
Scenario make_car_park(const DriveOptions& options);
Scenario make_walk(const DriveOptions& options);

}  // namespace lidar_mapping::simulation
