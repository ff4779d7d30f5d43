// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// With an unknown speed no more distance is searched than a vehicle goes in this time, however
/// long ago the last scan was: stamps may jump by years. Chosen: later a fast vehicle has left what
/// a scan shows, and a search takes 50 ms for each second.
constexpr double kLongestSearchedTime = 5.0;  // s

/// Starting poses for a search around the prediction, around other poses, and between these and the
/// prediction. Most of them lie ahead in the direction of the predicted twist, some are rotated,
/// because this is where a vehicle can be.
std::vector<MotionState> starts_around(const MotionState& prediction,
                                       const std::vector<Pose>& anchors);

/// Starting states for the second scan of a drive, `seconds` after the first one: at rest, and at
/// speeds in all directions of the LiDAR's horizontal plane, as far as kLongestSearchedTime allows.
std::vector<MotionState> starts_at_speed(const Pose& first, double seconds);

}  // namespace lidar_mapping::front_end
