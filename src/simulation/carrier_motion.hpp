// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "track.hpp"

namespace lidar_mapping::simulation {

/// A person or a robot with legs that carries the sensors: each footfall pushes the body, which
/// hangs on damped springs. Peaks are those of single pushes and vary by a quarter.
struct Carrier {
  double height = 1.2;       ///< m, of base_link above the ground
  double arm = 0.0;          ///< m, of base_link before the axis about which the body turns
  double step_length = 0.7;  ///< m of way between footfalls
  double push = 0.0;         ///< m/s^2 upwards
  double push_s = 0.2;       ///< s that a push lasts
  double side_push = 0.0;    ///< m/s^2 to the left and right in turn
  double tilt_push = 0.0;    ///< rad/s^2 of pitch, and of roll and yaw to both sides in turn
  double spring_hz = 2.0;    ///< natural frequency of the body
  double damping = 0.4;      ///< of it, as a share of the critical
  double sway = 0.0;         ///< rad, of slow movements about each axis
  bool tilts_with_ground = false;
};

Carrier hand_held_carrier();
/// Runs with the sensor in the hands.
Carrier running_carrier();
/// A robot with four legs that trots: every footfall is a shock of 3 g.
Carrier legged_carrier();

/// `ground` holds what is under each state of the track.
SmoothTrajectory carried_trajectory(const Track& track, const std::vector<Ground>& ground,
                                    const Carrier& carrier, Random random);

}  // namespace lidar_mapping::simulation
