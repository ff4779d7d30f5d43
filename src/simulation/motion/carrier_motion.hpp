// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "motion/track.hpp"
#include "sensors/mounting.hpp"

namespace lidar_mapping::simulation {

/// A person or a legged robot that carries the sensors: each footfall pushes the body, which is
/// suspended on damped springs. Peak values are those of single pushes; they vary by a quarter. The
/// defaults are those of a person who walks with the sensor in the hands.
struct Carrier {
  double height = 1.2;  ///< Height of base_link above the ground, m.
  double arm = 0.35;  ///< Distance of base_link in front of the axis about which the body turns, m.
  double step_length = 0.7;  ///< Distance between footfalls, m.
  double push = 4.5;         ///< Peak acceleration upwards, m/s^2.
  double push_s = 0.2;       ///< Duration of a push, s.
  double side_push = 1.0;    ///< Peak acceleration alternately to the left and right, m/s^2.
  /// Peak angular acceleration of pitch, and alternately to both sides of roll and yaw, rad/s^2.
  double tilt_push = 8.0;
  double spring_hz = 2.0;  ///< Natural frequency of the body, Hz.
  double damping = 0.4;    ///< Damping as a fraction of the critical one.
  double sway = 0.1;       ///< Amplitude of slow movements about each axis, rad.
  bool tilts_with_ground = false;
  SensorMounting mounting = hand_held_mounting();
};

/// A person who walks with the sensor in the hands.
inline Carrier hand_held_carrier() { return {}; }
/// A person who runs with the sensor in the hands.
Carrier running_carrier();
/// A trotting robot with four legs: every footfall is a shock of 3 g.
Carrier legged_carrier();

/// Motion of a carrier along a track; `ground` holds the ground under each state of the track.
SmoothTrajectory carried_trajectory(const Track& track, const std::vector<Ground>& ground,
                                    const Carrier& carrier, Random random);

}  // namespace lidar_mapping::simulation
