#pragma once

#include <string>
#include <vector>

#include <nav_msgs/Path.h>
#include <visualization_msgs/MarkerArray.h>

#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"

namespace lidar_mapping::ros_border {

/// Stamps are those of the key frames.
nav_msgs::Path to_path(const KeyFramePoses& poses, const std::string& frame);

/// Key frames as dots, odometry between them as lines, loops that the graph uses in pink, those
/// that it leaves out in red, those on which it has not judged yet in yellow; candidates that
/// matching refused as thin red lines, undecided ones as thin yellow lines.
visualization_msgs::MarkerArray to_markers(const map::KeyFrameTrack& track,
                                           const std::vector<LoopVerdict>& loops,
                                           const std::vector<LoopVerdict>& candidates,
                                           const std::string& frame);

}  // namespace lidar_mapping::ros_border
