// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include "track.hpp"

namespace lidar_mapping::simulation {

/// A drone over the track: it stands on the ground, rises, flies some metres above the ground
/// under the track and lands at its end. Its rotors push along its z axis alone, so that it tilts
/// with every acceleration; now and then it rolls and pitches for a moment besides.
SmoothTrajectory flown_trajectory(const Track& track, const std::vector<Ground>& ground,
                                  Random random);

}  // namespace lidar_mapping::simulation
