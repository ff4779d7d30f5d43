// SPDX-License-Identifier: BSD-3-Clause
#include "display/path_display.hpp"

#include <vector>

#include "lidar_mapping/common/path_simplification.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

nav_msgs::Path to_path(const KeyFramePoses& poses, const std::string& frame, std::size_t limit) {
  std::vector<Eigen::Vector3d> positions;
  for (const KeyFramePose& pose : poses.poses) positions.push_back(pose.T_map_base.translation);
  nav_msgs::Path path;
  path.header.frame_id = frame;
  for (const std::size_t i : simplified_path(positions, limit)) {
    geometry_msgs::PoseStamped stamped;
    stamped.header = header_of(poses.poses[i].stamp, frame);
    stamped.pose = to_message(poses.poses[i].T_map_base);
    path.poses.push_back(stamped);
  }
  if (!path.poses.empty()) path.header.stamp = path.poses.back().header.stamp;
  return path;
}

}  // namespace lidar_mapping::ros_border
