// SPDX-License-Identifier: BSD-3-Clause
#include "display/graph_markers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "display/marker_layer.hpp"

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;

constexpr double kBridge = 3.0;  // m, above the path; chosen: apart from it in a view from the side
/// Height of the marks of degenerate sections, m. Chosen: mostly in tunnels, whose roof would hide
/// the marks.
constexpr double kOverRoofs = 10.0;

std_msgs::ColorRGBA color_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      return color(1.0F, 0.3F, 0.8F);
    case Verdict::kRefused:
      return color(0.95F, 0.15F, 0.1F);
    case Verdict::kUndecided:
      return color(0.95F, 0.85F, 0.1F);
  }
  return {};
}

/// Posts on both key frames and a beam between them, which is visible also if both passes are side
/// by side below the line of the path.
void add_bridge(Marker& marker, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d up(0.0, 0.0, kBridge);
  add_line(marker, from, from + up);
  add_line(marker, from + up, to + up);
  add_line(marker, to + up, to);
}

using Positions = std::map<KeyFrameIndex, Eigen::Vector3d>;

template <typename AddLine>
void add_verdicts(const Verdicts& verdicts, const Positions& positions, const AddLine& add,
                  MarkerLayer& layer) {
  for (const auto& [pair, verdict] : verdicts) {
    const auto from = positions.find(pair.first);
    const auto to = positions.find(pair.second);
    if (from == positions.end() || to == positions.end()) continue;
    Marker& marker = layer.piece_of(pair.second);
    add(marker, from->second, to->second);
    marker.colors.resize(marker.points.size(), color_of(verdict.verdict));
  }
}

/// Length of the colour scale: the smallest power of two in minutes that covers the drive.
Stamp scale_of(Stamp duration) {
  Stamp scale = from_seconds(60.0);
  while (scale < duration) scale *= 2;
  return scale;
}

/// Colour of an age from 0 to 1: 0 is blue, a quarter cyan, a half green, 1 red.
std_msgs::ColorRGBA color_of_age(double age) {
  const auto ramp = [&](double peak) {
    return static_cast<float>(std::clamp(2.0 - 4.0 * std::abs(age - peak), 0.0, 1.0));
  };
  return color(ramp(1.0), ramp(0.5), ramp(0.0));
}

}  // namespace

std::vector<Marker> graph_markers(const map::KeyFrameTrack& track, const Verdicts& loops,
                                  const Verdicts& candidates, const std::string& frame) {
  MarkerLayer dots("key_frames", Marker::SPHERE_LIST, 0.5, color(0.9F, 0.9F, 0.95F), frame);
  MarkerLayer lines("odometry", Marker::LINE_LIST, 0.15, color(0.3F, 0.55F, 0.95F), frame);
  MarkerLayer degenerate("degenerate", Marker::LINE_LIST, 1.2, color(1.0F, 0.55F, 0.0F), frame,
                         kOverRoofs);
  MarkerLayer bridges("loops", Marker::LINE_LIST, 0.8, color_of(Verdict::kAccepted), frame);
  MarkerLayer candidate_lines("candidates", Marker::LINE_LIST, 0.15, color_of(Verdict::kRefused),
                              frame);
  Positions positions;
  std::uint32_t segment = 0;
  const Eigen::Vector3d* before = nullptr;
  for (const map::TrackedKeyFrame& key_frame : track.key_frames()) {
    const Eigen::Vector3d& position =
        positions.emplace(key_frame.pose.index, key_frame.pose.T_map_base.translation)
            .first->second;
    dots.piece_of(key_frame.pose.index).points.push_back(to_point(position));
    if (before != nullptr && key_frame.segment == segment) {
      add_line(lines.piece_of(key_frame.pose.index), *before, position);
      if (key_frame.degenerate)
        add_line(degenerate.piece_of(key_frame.pose.index), *before, position);
    }
    before = &position;
    segment = key_frame.segment;
  }
  add_verdicts(loops, positions, add_bridge, bridges);
  add_verdicts(candidates, positions, add_line, candidate_lines);
  std::vector<Marker> markers;
  for (MarkerLayer* layer : {&dots, &lines, &degenerate, &bridges, &candidate_lines}) {
    for (Marker& marker : layer->take()) markers.push_back(std::move(marker));
  }
  return markers;
}

std::vector<Marker> gnss_markers(const std::vector<Eigen::Vector3d>& positions,
                                 const std::string& frame) {
  MarkerLayer layer("gnss", Marker::SPHERE_LIST, 0.6, color(0.25F, 0.9F, 0.35F), frame);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    layer.piece_of(i).points.push_back(to_point(positions[i]));
  }
  return layer.take();
}

std::vector<Marker> age_markers(const map::KeyFrameTrack& track, const std::string& frame) {
  const KeyFramePoses poses = track.poses();
  if (poses.poses.empty()) return {};
  const Stamp begin = poses.poses.front().stamp;
  const double scale = to_seconds(scale_of(poses.poses.back().stamp - begin));
  MarkerLayer dots("age", Marker::SPHERE_LIST, 0.9, color(1.0F, 1.0F, 1.0F), frame);
  for (const KeyFramePose& pose : poses.poses) {
    Marker& marker = dots.piece_of(pose.index);
    marker.points.push_back(to_point(pose.T_map_base.translation));
    marker.colors.push_back(color_of_age(to_seconds(pose.stamp - begin) / scale));
  }
  return dots.take();
}

}  // namespace lidar_mapping::ros_border
