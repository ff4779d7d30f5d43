// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/node_config.hpp"

namespace lidar_mapping::ros_border {

namespace {

std::string problem_of_frame(const std::string& name, const std::string& frame) {
  if (frame.empty()) return name + " is empty; name a frame";
  if (frame.front() == '/') return name + ": '" + frame + "' starts with a slash; leave it out";
  return "";
}

std::string problem_of_frames(const NodeFields& fields) {
  for (const auto& [name, frame] :
       {std::pair("map_frame", fields.map_frame), std::pair("odom_frame", fields.odom_frame),
        std::pair("base_frame", fields.base_frame)}) {
    const std::string problem = problem_of_frame(name, frame);
    if (!problem.empty()) return problem;
  }
  return "";
}

}  // namespace

const config::Schema<NodeFields>& NodeFields::schema() {
  static const auto schema =
      config::Schema<NodeFields>("node", "Parameters of every node")
          .text("map_frame", &NodeFields::map_frame,
                "Frame of the map: East-North-Up with GNSS, else that of the first pose.")
          .text("odom_frame", &NodeFields::odom_frame,
                "Frame in which odometry is smooth and drifts.")
          .text("base_frame", &NodeFields::base_frame, "Frame of the vehicle.")
          .integer("queue_size", &NodeFields::queue_size, {1, 100000}, "messages",
                   "Messages of a topic that may wait; beyond that the oldest is dropped, counted "
                   "and reported.")
          .check(problem_of_frames);
  return schema;
}

}  // namespace lidar_mapping::ros_border
