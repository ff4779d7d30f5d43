// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory.hpp"

#include <cmath>
#include <limits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/sorted_values.hpp"

namespace lidar_mapping::loop_closing {

namespace {

/// Limit for fixes without a key frame, of which the oldest are dropped: most scans are no key
/// frames. Chosen: over three minutes at 10 Hz, later than any key frame comes.
constexpr std::size_t kMaxEarlyPositions = 2000;

// Metres; a larger change of the height at once is neither a ramp nor stairs. Chosen: lower, stairs
// count as jumps, higher, jumps of a bad pose pass.
constexpr double kMinHeightJump = 1.5;

/// Difference of the height of a step from the slope of the previous step, if it is too large for a
/// motion. Such a jump is an error, for instance a match on another storey.
double height_jump(const Pose& T_odom_first, const Pose& T_odom_second, const Pose& T_odom_third) {
  const Eigen::Vector3d before = (T_odom_first.inverse() * T_odom_second).translation;
  const Eigen::Vector3d step = (T_odom_second.inverse() * T_odom_third).translation;
  const double slope = before.norm() > 0.1 ? before.z() / before.norm() : 0.0;
  const double jump = std::abs(step.z() - slope * step.head<2>().norm());
  return jump > kMinHeightJump ? jump : 0.0;
}

}  // namespace

Trajectory::NodeId Trajectory::append(const KeyFrame& key_frame) {
  if (!nodes_.empty() && key_frame.index <= nodes_.back().index) {
    throw InputError("key frame " + std::to_string(key_frame.index) + " comes after key frame " +
                     std::to_string(nodes_.back().index) + "; indices must increase");
  }
  TrajectoryNode node;
  node.index = key_frame.index;
  node.segment = key_frame.segment;
  node.stamp = key_frame.stamp;
  node.T_odom_base = key_frame.T_odom_base;
  if (!nodes_.empty()) {
    const TrajectoryNode& last = nodes_.back();
    const bool continues = last.segment == node.segment;
    node.travelled = last.travelled;
    node.height_jumps = last.height_jumps;
    if (continues) {
      node.travelled += (node.T_odom_base.translation - last.T_odom_base.translation).norm();
    }
    if (continues && nodes_.size() > 1 && nodes_[nodes_.size() - 2].segment == node.segment) {
      node.height_jumps +=
          height_jump(nodes_[nodes_.size() - 2].T_odom_base, last.T_odom_base, node.T_odom_base);
    }
  }
  if (const auto position = early_positions_.find(node.stamp); position != early_positions_.end()) {
    node.gnss = position->second;
  }
  early_positions_.erase(early_positions_.begin(), early_positions_.upper_bound(node.stamp));
  nodes_.push_back(node);
  const NodeId id = nodes_.size() - 1;
  at_stamp_[node.stamp] = id;
  const auto pose = early_poses_.find(node.index);
  nodes_[id].optimised = pose != early_poses_.end();
  nodes_[id].T_map_base = nodes_[id].optimised ? pose->second : predicted(id);
  if (nodes_[id].optimised) early_poses_.erase(pose);
  return id;
}

/// The pose of a node by odometry from the previous node.
Pose Trajectory::predicted(NodeId id) const {
  const TrajectoryNode& node = nodes_[id];
  if (id == 0 || nodes_[id - 1].segment != node.segment) return node.T_odom_base;
  const TrajectoryNode& before = nodes_[id - 1];
  return before.T_map_base * (before.T_odom_base.inverse() * node.T_odom_base);
}

std::vector<Trajectory::NodeId> Trajectory::update(const KeyFramePoses& poses) {
  if (poses.whole) early_poses_.clear();
  std::vector<bool> changed(nodes_.size(), false);
  for (const KeyFramePose& pose : poses.poses) {
    const auto id = find(pose.index);
    if (id) {
      nodes_[*id].T_map_base = pose.T_map_base;
      nodes_[*id].optimised = true;
      changed[*id] = true;
    } else if (nodes_.empty() || pose.index > nodes_.back().index) {
      early_poses_[pose.index] = pose.T_map_base;
    }
  }
  std::vector<NodeId> result;
  for (NodeId id = 0; id < nodes_.size(); ++id) {
    if (!nodes_[id].optimised && id > 0 && changed[id - 1]) {
      nodes_[id].T_map_base = predicted(id);
      changed[id] = true;
    }
    if (changed[id]) result.push_back(id);
  }
  return result;
}

std::optional<Trajectory::NodeId> Trajectory::add_gnss(const GnssPosition& position) {
  const auto node = at_stamp_.find(position.stamp);
  if (node != at_stamp_.end()) {
    nodes_[node->second].gnss = position;
    return node->second;
  }
  early_positions_[position.stamp] = position;
  if (early_positions_.size() > kMaxEarlyPositions)
    early_positions_.erase(early_positions_.begin());
  return std::nullopt;
}

std::optional<Trajectory::NodeId> Trajectory::find(KeyFrameIndex index) const {
  const auto node = find_index(nodes_, index);
  if (node == nodes_.end()) return std::nullopt;
  return static_cast<NodeId>(node - nodes_.begin());
}

double Trajectory::path_length_between(NodeId a, NodeId b) const {
  if (nodes_[a].segment != nodes_[b].segment) return std::numeric_limits<double>::infinity();
  return std::abs(nodes_[a].travelled - nodes_[b].travelled);
}

}  // namespace lidar_mapping::loop_closing
