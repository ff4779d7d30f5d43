// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::map {

/// A key frame as it lies in the map.
struct TrackedKeyFrame {
  KeyFramePose pose;
  std::uint32_t segment = 0;
  bool degenerate = false;  ///< odometry did not see all of the motion to it
};

/// Where the key frames of a run lie in the map: optimised poses where the back end has given some,
/// odometry moved by the newest correction behind them. Odometry is kept as it came, so corrections
/// never add up; everything is joined by index.
class KeyFrameTrack {
 public:
  /// The cloud is not kept.
  void add(const KeyFrame& key_frame);
  void update(const KeyFramePoses& poses);

  /// All key frames, by index.
  KeyFramePoses poses() const;
  /// Odometry alone, laid so that the first key frame is where it is in poses().
  KeyFramePoses odometry() const;
  /// The same as poses(), with what else there is to show of them.
  std::vector<TrackedKeyFrame> key_frames() const;
  std::size_t size() const { return nodes_.size(); }
  /// Of the newest key frame with an optimised pose; identity if there is none.
  Pose T_map_odom() const;

 private:
  struct Node {
    Stamp stamp = 0;
    std::uint32_t segment = 0;
    bool degenerate = false;
    Pose T_odom_base;
  };
  std::map<KeyFrameIndex, Node> nodes_;
  std::map<KeyFrameIndex, Pose> optimized_;  ///< T_map_base
  std::uint32_t revision_ = 0;
};

}  // namespace lidar_mapping::map
