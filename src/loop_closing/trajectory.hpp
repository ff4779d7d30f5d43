// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::loop_closing {

/// What is kept of a key frame's place; clouds are kept elsewhere.
struct TrajectoryNode {
  KeyFrameIndex index = 0;
  std::uint32_t segment = 0;
  Stamp stamp = 0;
  Pose T_odom_base;
  Pose T_map_base;            ///< newest estimate
  bool optimised = false;     ///< the estimate came from the back end, not from odometry behind it
  double travelled = 0.0;     ///< way from the first key frame, m
  double height_jumps = 0.0;  ///< sum of the heights that odometry has jumped so far, m
  std::optional<GnssPosition> gnss;
};

/// The key frames in the newest estimate: the back end's poses as far as they reach, odometry
/// chained to the last of them from there on. Nodes are numbered in the order of their arrival,
/// which is the order of their key frames' indices.
class Trajectory {
 public:
  using NodeId = std::size_t;

  /// Appends a key frame. Throws InputError unless its index is greater than all before.
  NodeId append(const KeyFrame& key_frame);
  /// Takes in the back end's poses; returns the nodes whose estimate changed.
  std::vector<NodeId> update(const KeyFramePoses& poses);
  /// Keeps a position; returns the node with that stamp if it is there already.
  std::optional<NodeId> add_gnss(const GnssPosition& position);

  std::size_t size() const { return nodes_.size(); }
  const TrajectoryNode& operator[](NodeId id) const { return nodes_[id]; }
  std::optional<NodeId> find(KeyFrameIndex index) const;

 private:
  Pose predicted(NodeId id) const;

  std::vector<TrajectoryNode> nodes_;
  std::map<Stamp, NodeId> at_stamp_;               // drives that were joined may overlap in time
  std::map<KeyFrameIndex, Pose> early_poses_;      // of key frames that have not come yet
  std::map<Stamp, GnssPosition> early_positions_;  // of stamps that have not come yet
};

}  // namespace lidar_mapping::loop_closing
