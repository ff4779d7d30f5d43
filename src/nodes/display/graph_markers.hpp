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

/// Number of key frames in a marker. When one of them changes, the marker is sent again.
constexpr KeyFrameIndex kKeyFramesPerMarker = 100;

/// Markers of the graph, in namespaces that rviz switches on and off, with the number of the piece
/// of the path as id: key_frames as dots; odometry between them as lines; degenerate, the sections
/// along which odometry did not observe all of the motion, as thick orange lines; loops as bridges
/// over the path, pink if the graph uses them, red if not, yellow without verdict; candidates as
/// thin lines, red if matching refused them, yellow if undecided. Stamps are zero, so that rviz
/// shows the markers at any time.
std::vector<visualization_msgs::Marker> graph_markers(const map::KeyFrameTrack& track,
                                                      const Verdicts& loops,
                                                      const Verdicts& candidates,
                                                      const std::string& frame);

/// Antenna positions as green dots, namespace gnss.
std::vector<visualization_msgs::Marker> gnss_markers(const std::vector<Eigen::Vector3d>& positions,
                                                     const std::string& frame);

/// Key frames as dots in the colour of their age, namespace age: from blue, the begin of the drive,
/// over green to red. The scale ends at the first of 1, 2, 4, 8 ... minutes that the drive has not
/// reached: if it changed with every key frame, every dot would have to be sent again.
std::vector<visualization_msgs::Marker> age_markers(const map::KeyFrameTrack& track,
                                                    const std::string& frame);

}  // namespace lidar_mapping::ros_border
