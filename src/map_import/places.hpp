// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/trajectory.hpp"

#include "open_ground.hpp"

namespace lidar_mapping::map_import {

/// Where a key frame is to stand.
struct Place {
  Stamp stamp = 0;
  Pose T_map_base;
};

/// Places on the open ground, the middle of streets first: no two of a storey are nearer to each
/// other than `spacing` (m), and no open cell is farther than that from one. base_link lies
/// `base_height` (m) above the ground, with the tilt of the ground and heading along x. They are in
/// the order of a walk, so that each is near the one before where that is possible, one second
/// apart.
std::vector<Place> places_on_ground(const std::vector<OpenCell>& ground, double spacing,
                                    double base_height);

/// Places along poses T_map_base in their order, with their stamps (seconds, where they have none).
/// A pose that is nearer than `spacing` (m) to an earlier place of the same storey is left out.
std::vector<Place> places_along(const Trajectory& trajectory, double spacing);

}  // namespace lidar_mapping::map_import
