// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The last key frames and their joint cloud.
class KeyFrameWindow {
 public:
  /// Holds at most `capacity` key frames. `resolution` (m) is the voxel size that thins out their
  /// joint cloud; 0 keeps all points.
  KeyFrameWindow(std::size_t capacity, double resolution)
      : capacity_(capacity), resolution_(resolution) {}

  bool empty() const { return frames_.empty(); }
  void clear() { frames_.clear(); }
  /// Adds a key frame; if the window is full, the oldest one is removed. `cloud` is in base_link.
  void push(const Pose& T_odom_base, PointCloud cloud);
  const Pose& newest_pose() const { return frames_.back().T_odom_base; }
  /// All clouds in the frame `a`. They are thinned out only if the window is at least half full:
  /// before, all points are needed.
  PointCloud joint_cloud(const Pose& T_a_odom) const;

 private:
  struct Frame {
    Pose T_odom_base;
    PointCloud cloud;
  };

  std::size_t capacity_;
  double resolution_;
  std::deque<Frame> frames_;
};

}  // namespace lidar_mapping::front_end
