// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The last few key frames, and their joint cloud.
class KeyFrameWindow {
 public:
  /// At most `capacity` key frames; `resolution` (m) thins their joint cloud out, 0 never.
  KeyFrameWindow(std::size_t capacity, double resolution)
      : capacity_(capacity), resolution_(resolution) {}

  bool empty() const { return frames_.empty(); }
  void clear() { frames_.clear(); }
  /// The oldest one leaves where the window is full. `cloud` is in base_link.
  void push(const Pose& T_odom_base, PointCloud cloud);
  const Pose& newest_pose() const { return frames_.back().T_odom_base; }
  /// All clouds in the frame `a`. Thinned out from half a window on: of fewer there is nothing to
  /// spare.
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
