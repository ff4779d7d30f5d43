// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/localization/localizer.hpp"

namespace lidar_mapping::ros_border {

/// The points of a scan in `map_frame`, as the localiser has placed them, with the fields x y z (m)
/// and agreement (0 to 1, or localization::kNotInMap), all FLOAT32.
sensor_msgs::PointCloud2 matched_cloud(const std::vector<localization::MatchedPoint>& points,
                                       const Pose& T_map_base, Stamp stamp,
                                       const std::string& map_frame);

}  // namespace lidar_mapping::ros_border
