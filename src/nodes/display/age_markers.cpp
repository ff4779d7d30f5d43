// SPDX-License-Identifier: BSD-3-Clause
#include "display/age_markers.hpp"

#include <algorithm>
#include <cmath>

#include "display/marker_layer.hpp"

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;

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
