// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/own_transform.hpp"

#include <ros/console.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

OwnTransform::OwnTransform(NodeContext& context, const std::string& parent,
                           const std::string& child)
    : context_(context), parent_(frame_name(parent)), child_(frame_name(child)) {
  for (const char* topic : {"/tf", "/tf_static"}) {
    subscribers_.push_back(subscribe_arrivals<tf2_msgs::TFMessage>(
        context, topic, kTransportQueue,
        [this](const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
          look_for_others(event.getPublisherName(), *event.getConstMessage());
        }));
  }
}

void OwnTransform::send(const Pose& T_parent_child, Stamp stamp) {
  transforms_.sendTransform(stamped_transform(T_parent_child, stamp, parent_, child_));
}

void OwnTransform::look_for_others(const std::string& publisher,
                                   const tf2_msgs::TFMessage& message) {
  if (publisher == ros::this_node::getName()) return;
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (frame_name(transform.child_frame_id) != child_) continue;
    if (!reported_.insert(publisher).second) return;
    const std::string other =
        frame_name(transform.header.frame_id) + " -> " + child_ + " of " + publisher;
    context_.diagnostics.set("second parent of " + child_, other);
    ROS_WARN_STREAM("tf has " << other << " beside " << parent_ << " -> " << child_
                              << " of this node, so poses by tf are those of the one or of the "
                                 "other; switch that transform off, play a recording "
                                 "with /tf:=/tf_recorded, or name the vehicle's uppermost frame "
                                 "by base_frame");
    return;
  }
}

}  // namespace lidar_mapping::ros_border
