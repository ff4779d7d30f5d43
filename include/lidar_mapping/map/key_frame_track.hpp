// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::map {

/// A key frame with its pose in the map.
struct TrackedKeyFrame {
  KeyFramePose pose;  ///< Index, stamp and T_map_base.
  /// Number of the segment: a part of the drive without a gap in odometry.
  std::uint32_t segment = 0;
  bool degenerate = false;  ///< The odometry did not observe all directions of the motion to it.
};

/// Poses of the key frames of a run in the map: the optimised pose where the back end has given
/// one; otherwise the pose of the odometry, moved by the correction of the newest optimised key
/// frame before it. The poses of the odometry are stored unchanged, so that corrections never add
/// up. Everything is associated by the index of the key frame.
class KeyFrameTrack {
 public:
  /// Adds a key frame; its cloud is not stored.
  void add(const KeyFrame& key_frame);
  /// Replaces all optimised poses if `poses` are complete (KeyFramePoses::whole), else only those
  /// given. Returns the largest distance by which one of these key frames moves, m.
  double update(const KeyFramePoses& poses);

  /// Poses of all key frames, in the order of their indices.
  KeyFramePoses poses() const;
  /// Poses by odometry alone, aligned so that the first key frame of each segment lies where it is
  /// in poses(): between two segments the odometry knows no motion.
  KeyFramePoses odometry() const;
  /// The same poses as poses(), with what a display shows beside them.
  std::vector<TrackedKeyFrame> key_frames() const;
  /// Number of key frames.
  std::size_t size() const { return nodes_.size(); }

 private:
  struct Node {
    Stamp stamp = 0;
    std::uint32_t segment = 0;
    bool degenerate = false;
    Pose T_odom_base;
  };
  std::optional<Pose> pose_of(KeyFrameIndex index) const;

  std::map<KeyFrameIndex, Node> nodes_;
  std::map<KeyFrameIndex, Pose> optimized_;  ///< T_map_base
  std::uint32_t revision_ = 0;
};

}  // namespace lidar_mapping::map
