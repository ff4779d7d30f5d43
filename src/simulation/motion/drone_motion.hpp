// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "motion/track.hpp"

namespace lidar_mapping::simulation {

/// Motion of a drone along the track: it stands on the ground, takes off, flies some metres above
/// the ground and lands at the end. Its rotors accelerate it along its z axis alone, so that it
/// tilts with every acceleration; now and then it rolls or pitches for a moment.
SmoothTrajectory flown_trajectory(const Track& track, const std::vector<Ground>& ground,
                                  Random random);

}  // namespace lidar_mapping::simulation
