// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"
#include "lidar_mapping/simulation/world.hpp"

#include "motion/path.hpp"
#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// A path that road users follow, one after the other.
struct TrafficLane {
  Path path;
  double slowest = 6.0;   ///< Least speed, m/s.
  double fastest = 12.0;  ///< Largest speed, m/s.
  bool pedestrians = false;
  double height = 0.0;  ///< Height above the terrain, m.
};

/// Adds up to `count` road users on the lanes, none of which ever comes close to the vehicle on its
/// trajectory or to another one.
void add_traffic(World& world, const std::vector<TrafficLane>& lanes, const Terrain& terrain,
                 const SmoothTrajectory& trajectory, int count, Random random);

/// Adds a car that drives ahead of the vehicle on its path. `stations` are those of the vehicle,
/// every kControlStep seconds.
void add_car_ahead(World& world, const Path& path, const std::vector<double>& stations,
                   const Terrain& terrain, Random random);

}  // namespace lidar_mapping::simulation
