// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/ros/bag_set.hpp"

namespace lidar_mapping::ros_border {

/// The topic of nav_msgs/Odometry whose twist is a velocity of its child_frame_id in that frame's
/// axes: over the first times at which it moves, the twist has to agree with how its own poses
/// change. So a velocity in East-North-Up, one in another unit and a twist that is empty or means
/// something else are left out. Of several the one with most messages; empty if there is none.
/// Topics that this package publishes are left out.
std::string odometry_with_twist(const BagSet& bags);

}  // namespace lidar_mapping::ros_border
