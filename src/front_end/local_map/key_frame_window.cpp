// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/key_frame_window.hpp"

#include <utility>

#include "lidar_mapping/common/voxel_filter.hpp"

namespace lidar_mapping::front_end {

void KeyFrameWindow::push(const Pose& T_odom_base, PointCloud cloud) {
  frames_.push_back({T_odom_base, std::move(cloud)});
  if (frames_.size() > capacity_) frames_.pop_front();
}

PointCloud KeyFrameWindow::joint_cloud(const Pose& T_a_odom) const {
  PointCloud joint;
  for (const Frame& frame : frames_) {
    const PointCloud cloud = transformed(frame.cloud, T_a_odom * frame.T_odom_base);
    joint.points.insert(joint.points.end(), cloud.points.begin(), cloud.points.end());
  }
  return 2 * frames_.size() >= capacity_ ? voxel_filtered(joint, resolution_) : joint;
}

}  // namespace lidar_mapping::front_end
