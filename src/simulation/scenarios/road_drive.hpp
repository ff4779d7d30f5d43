// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "motion/path.hpp"
#include "motion/vehicle_motion.hpp"
#include "scenarios/scenario.hpp"
#include "sensors/mounting.hpp"
#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// Stations over time of a drive along a path without its first `begin` and its last `end` metres;
/// of one that is driven in reverse, these are the other way round.
inline std::vector<double> stations_along(const Path& path, double begin, double end, bool reverse,
                                          const SpeedLimits& limits,
                                          const std::vector<Halt>& halts = {}) {
  if (reverse) std::swap(begin, end);
  return stations_over_time(path, begin, path.length() - end, limits, halts);
}

/// Time at which the drive reaches a station, s after its beginning.
inline double time_at(const std::vector<double>& stations, double station) {
  const auto it = std::lower_bound(stations.begin(), stations.end(), station);
  return static_cast<double>(it - stations.begin()) * kControlStep;
}

/// The scenario of a car, still without a world.
inline Scenario car_scenario(const Path& path, const std::vector<double>& stations,
                             const GroundUnder& ground, Random random,
                             std::vector<GnssOutage> covered = {}) {
  return {
      {}, vehicle_trajectory(path, stations, ground, random), car_mounting(), std::move(covered)};
}

/// The terrain under a path. Both must outlive the result.
inline GroundUnder ground_along(const Path& path, const Terrain& terrain) {
  return [&path, &terrain](double station) {
    const Eigen::Vector2d at = path.position(station);
    return Ground{terrain.height(at), terrain.gradient(at)};
  };
}

}  // namespace lidar_mapping::simulation
