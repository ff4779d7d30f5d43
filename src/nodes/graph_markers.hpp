// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <visualization_msgs/MarkerArray.h>

#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"

namespace lidar_mapping::ros_border {

/// Loops or candidates by their two key frames.
using Verdicts = std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict>;

/// The graph in pieces of this many key frames: a piece is the least that is sent again when
/// something in it has changed.
constexpr KeyFrameIndex kKeyFramesPerMarker = 100;

/// Everything there is to see of the graph, in namespaces that rviz switches on and off, a marker
/// per piece (its id): key_frames as dots; odometry between them as lines; degenerate, the
/// stretches along which it did not see all of the motion, as thick orange lines; loops as bridges
/// over the path, in pink those that the graph uses, in red those that it leaves out, in yellow
/// those on which it has not judged yet; candidates as thin lines, red those that matching refused,
/// yellow the undecided. Stamps are zero: rviz shows them wherever its clock stands.
std::vector<visualization_msgs::Marker> graph_markers(const map::KeyFrameTrack& track,
                                                      const Verdicts& loops,
                                                      const Verdicts& candidates,
                                                      const std::string& frame);

/// Antenna positions as green dots, namespace gnss.
std::vector<visualization_msgs::Marker> gnss_markers(const std::vector<Eigen::Vector3d>& positions,
                                                     const std::string& frame);

}  // namespace lidar_mapping::ros_border
