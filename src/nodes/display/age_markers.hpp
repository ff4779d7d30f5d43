// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <visualization_msgs/Marker.h>

#include "lidar_mapping/map/key_frame_track.hpp"

namespace lidar_mapping::ros_border {

/// Key frames as dots in the colour of their age, namespace age: from blue, the begin of the drive,
/// over green to red. The scale ends at the first of 1, 2, 4, 8 ... minutes that the drive has not
/// reached: if it changed with every key frame, every dot would have to be sent again.
std::vector<visualization_msgs::Marker> age_markers(const map::KeyFrameTrack& track,
                                                    const std::string& frame);

}  // namespace lidar_mapping::ros_border
