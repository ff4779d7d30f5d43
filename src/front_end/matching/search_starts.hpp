// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// Starting poses for a search around the prediction, around other poses, and between these and the
/// prediction. Most of them lie ahead in the direction of the predicted twist, some are rotated,
/// because this is where a vehicle can be.
std::vector<MotionState> starts_around(const MotionState& prediction,
                                       const std::vector<Pose>& anchors);

/// Starting states for the second scan of a drive, `seconds` after the first one: at rest, and at
/// speeds in all directions of the LiDAR's horizontal plane.
std::vector<MotionState> starts_at_speed(const Pose& first, double seconds);

}  // namespace lidar_mapping::front_end
