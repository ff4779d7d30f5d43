// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <vector>

#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/transform_broadcaster.h>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/node.hpp"

namespace lidar_mapping::ros_border {

/// Publishes the pose of one frame on /tf, and reports whoever else does. A frame has one parent:
/// with two publishers tf gives the pose by the one or by the other, whichever stamp is newer.
class OwnTransform {
 public:
  /// `parent` and `child` are the names of the frames.
  OwnTransform(NodeContext& context, const std::string& parent, const std::string& child);

  /// Publishes T_parent_child. One thread calls it.
  void send(const Pose& T_parent_child, Stamp stamp);

 private:
  void look_for_others(const std::string& publisher, const tf2_msgs::TFMessage& message);

  NodeContext& context_;
  std::string parent_;
  std::string child_;
  tf2_ros::TransformBroadcaster transforms_;
  std::set<std::string> reported_;  ///< publishers
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace lidar_mapping::ros_border
