// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/key_frame_track.hpp"

#include <algorithm>

namespace lidar_mapping::map {

void KeyFrameTrack::add(const KeyFrame& key_frame) {
  nodes_[key_frame.index] = {key_frame.stamp, key_frame.segment,
                             !key_frame.degenerate_directions.empty(), key_frame.T_odom_base};
}

double KeyFrameTrack::update(const KeyFramePoses& poses) {
  double largest = 0.0;
  for (const KeyFramePose& pose : poses.poses) {
    if (const std::optional<Pose> before = pose_of(pose.index)) {
      largest = std::max(largest, (pose.T_map_base.translation - before->translation).norm());
    }
  }
  if (poses.whole) optimized_.clear();
  for (const KeyFramePose& pose : poses.poses) optimized_[pose.index] = pose.T_map_base;
  revision_ = poses.revision;
  return largest;
}

std::optional<Pose> KeyFrameTrack::pose_of(KeyFrameIndex index) const {
  const auto node = nodes_.find(index);
  if (node == nodes_.end()) return std::nullopt;
  for (auto next = optimized_.upper_bound(index); next != optimized_.begin();) {
    --next;
    const auto before = nodes_.find(next->first);
    if (before == nodes_.end()) continue;
    return next->second * before->second.T_odom_base.inverse() * node->second.T_odom_base;
  }
  return node->second.T_odom_base;
}

KeyFramePoses KeyFrameTrack::poses() const {
  KeyFramePoses result;
  result.revision = revision_;
  Pose T_map_odom;
  for (const auto& [index, node] : nodes_) {
    const auto optimized = optimized_.find(index);
    if (optimized != optimized_.end()) {
      T_map_odom = optimized->second * node.T_odom_base.inverse();
      result.poses.push_back({index, node.stamp, optimized->second});
    } else {
      result.poses.push_back({index, node.stamp, T_map_odom * node.T_odom_base});
    }
  }
  return result;
}

KeyFramePoses KeyFrameTrack::odometry() const {
  KeyFramePoses result = poses();
  Pose T_map_odom;
  std::optional<std::uint32_t> segment;
  for (KeyFramePose& pose : result.poses) {
    const Node& node = nodes_.at(pose.index);
    if (segment != node.segment) T_map_odom = pose.T_map_base * node.T_odom_base.inverse();
    segment = node.segment;
    pose.T_map_base = T_map_odom * node.T_odom_base;
  }
  return result;
}

std::vector<TrackedKeyFrame> KeyFrameTrack::key_frames() const {
  const KeyFramePoses all = poses();
  std::vector<TrackedKeyFrame> result;
  result.reserve(nodes_.size());
  auto pose = all.poses.begin();
  for (const auto& [index, node] : nodes_) {
    result.push_back({*pose++, node.segment, node.degenerate});
  }
  return result;
}

}  // namespace lidar_mapping::map
