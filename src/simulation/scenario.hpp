#pragma once

#include <vector>

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/random.hpp"

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

}  // namespace lidar_mapping::simulation
