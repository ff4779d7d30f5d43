// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "motion/path.hpp"
#include "motion/vehicle_motion.hpp"
#include "worlds/terrain.hpp"

namespace lidar_mapping::simulation {

/// A drive along a part of a path.
struct RoadDrive {
  Path path;
  double begin = 0.0;  ///< First station, m.
  double end = 0.0;
  SpeedLimits limits;
  std::vector<Halt> halts;

  std::vector<double> stations() const {
    return stations_over_time(path, begin, end, limits, halts);
  }
};

/// The drive along a path without its first `begin` and its last `end` metres; of one that is
/// driven in reverse, these are the other way round.
inline RoadDrive drive_along(const Path& path, double begin, double end, bool reverse) {
  if (reverse) std::swap(begin, end);
  return {path, begin, path.length() - end, {}, {}};
}

/// The terrain under a path. Both must outlive the result.
inline GroundUnder ground_along(const Path& path, const Terrain& terrain) {
  return [&path, &terrain](double station) {
    const Eigen::Vector2d at = path.position(station);
    return Ground{terrain.height(at), terrain.gradient(at)};
  };
}

}  // namespace lidar_mapping::simulation
