// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::loop_closing {

/// The pose of a key frame with what belongs to it; clouds are stored elsewhere.
struct TrajectoryNode {
  KeyFrameIndex index = 0;
  std::uint32_t segment = 0;
  Stamp stamp = 0;
  Pose T_odom_base;
  Pose T_map_base;            ///< newest estimate
  bool optimised = false;     ///< the estimate comes from the back end, not from odometry after it
  double travelled = 0.0;     ///< distance travelled since the first key frame, m
  double height_jumps = 0.0;  ///< sum of the jumps in height of odometry so far, m
  std::optional<GnssPosition> gnss;
};

/// The key frames in the newest estimate: the poses of the back end as far as they exist, followed
/// by odometry from the last of them. Nodes are numbered in the order of their key frames' indices.
class Trajectory {
 public:
  using NodeId = std::size_t;

  /// Appends a key frame. Throws InputError unless its index is larger than all before.
  NodeId append(const KeyFrame& key_frame);
  /// Updates the poses to those of the back end and returns the nodes whose estimate changed.
  std::vector<NodeId> update(const KeyFramePoses& poses);
  /// Adds a position and returns the node with that stamp, if it exists already.
  std::optional<NodeId> add_gnss(const GnssPosition& position);

  std::size_t size() const { return nodes_.size(); }
  const TrajectoryNode& operator[](NodeId id) const { return nodes_[id]; }
  std::optional<NodeId> find(KeyFrameIndex index) const;
  /// Distance travelled between two nodes, m; infinite between two segments.
  double path_length_between(NodeId a, NodeId b) const;

 private:
  Pose predicted(NodeId id) const;

  std::vector<TrajectoryNode> nodes_;
  std::map<Stamp, NodeId> at_stamp_;               // merged drives may overlap in time
  std::map<KeyFrameIndex, Pose> early_poses_;      // of key frames that were not appended yet
  std::map<Stamp, GnssPosition> early_positions_;  // of stamps that were not appended yet
};

}  // namespace lidar_mapping::loop_closing
