// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "motion/path.hpp"

namespace lidar_mapping::simulation {

/// Limits of the speed of a vehicle along a path.
struct SpeedLimits {
  double speed = 12.0;        ///< Largest speed, m/s.
  double lateral = 2.4;       ///< Largest lateral acceleration in curves, m/s^2.
  double longitudinal = 1.8;  ///< Largest longitudinal acceleration, m/s^2.
};

/// A halt of some seconds at a station of the path.
struct Halt {
  double station = 0.0;
  double seconds = 0.0;
};

/// Height and slope of the ground under a station of the path.
struct Ground {
  double height = 0.0;
  /// Rise per metre along x and y of the map frame.
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
};
using GroundUnder = std::function<Ground(double station)>;

/// Time between the control points of the trajectories of vehicles, s. Chosen: a spline through
/// them holds motions up to about 10 Hz.
constexpr double kControlStep = 0.02;

/// Stations every `step` seconds, from rest at station `begin` to rest at `end`.
std::vector<double> stations_over_time(const Path& path, double begin, double end,
                                       const SpeedLimits& limits, const std::vector<Halt>& halts,
                                       double step = kControlStep);

/// Motion of a car whose rear axle follows the path: it tilts with the ground, pitches and rolls
/// with its accelerations and vibrates on the road.
SmoothTrajectory vehicle_trajectory(const Path& path, const std::vector<double>& stations,
                                    const GroundUnder& ground, Random random);

}  // namespace lidar_mapping::simulation
