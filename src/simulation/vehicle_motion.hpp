// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "path.hpp"

namespace lidar_mapping::simulation {

/// How fast a vehicle goes along a path.
struct SpeedLimits {
  double speed = 12.0;        ///< m/s
  double lateral = 2.4;       ///< m/s^2 in curves
  double longitudinal = 1.8;  ///< m/s^2
};

/// A halt of some seconds at a station of the path.
struct Halt {
  double station = 0.0;
  double seconds = 0.0;
};

/// Height and slope of the ground under a station of the path.
struct Ground {
  double height = 0.0;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  ///< rise per metre along x and y of map
};
using GroundUnder = std::function<Ground(double station)>;

/// Time between the control points of vehicles' trajectories, s.
constexpr double kControlStep = 0.02;

/// Station every `step` seconds, from rest at station `begin` to rest at `end`.
std::vector<double> stations_over_time(const Path& path, double begin, double end,
                                       const SpeedLimits& limits, const std::vector<Halt>& halts,
                                       double step = kControlStep);

/// Motion of a car whose rear axle follows the path: it tilts with the ground, leans with its
/// accelerations and shakes on the road.
SmoothTrajectory vehicle_trajectory(const Path& path, const std::vector<double>& stations,
                                    const GroundUnder& ground, Random random);

}  // namespace lidar_mapping::simulation
