// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::ros_border {

/// Parameters that every node has. Topics are remapped as always in ROS.
struct NodeFields {
  /// Frame of the map: East-North-Up with GNSS, else that of the first pose.
  std::string map_frame = "map";
  /// Frame in which odometry is smooth and drifts.
  std::string odom_frame = "odom";
  /// Frame of the vehicle.
  std::string base_frame = "base_link";
  /// [messages] Messages of a topic that may wait; beyond that the oldest is dropped, counted and
  /// reported.
  int queue_size = 100;

  /// All fields.
  static const config::Schema<NodeFields>& schema();
};

/// Configuration of a node whose only parameters beside NodeFields are those of its stage.
template <typename StageConfig>
struct NodeConfig {
  NodeFields node;    ///< parameters that every node has
  StageConfig stage;  ///< parameters of the stage

  /// The fields of both; stage and summary are those of the stage.
  static const config::Schema<NodeConfig>& schema() {
    static const auto schema =
        config::Schema<NodeConfig>(StageConfig::schema().stage(), StageConfig::schema().summary())
            .include(&NodeConfig::node, NodeFields::schema())
            .include(&NodeConfig::stage, StageConfig::schema());
    return schema;
  }
};

/// The same for nodes that need the origin of the sensor.
template <typename StageConfig>
struct LidarNodeConfig {
  /// Parameters that every node has.
  NodeFields node;
  /// Frame of the LiDAR in tf, from whose position points were measured; may be empty.
  std::string lidar_frame;
  /// Parameters of the stage.
  StageConfig stage;

  /// All fields; stage and summary are those of the stage.
  static const config::Schema<LidarNodeConfig>& schema() {
    static const auto schema =
        config::Schema<LidarNodeConfig>(StageConfig::schema().stage(),
                                        StageConfig::schema().summary())
            .include(&LidarNodeConfig::node, NodeFields::schema())
            .text(
                "lidar_frame", &LidarNodeConfig::lidar_frame,
                "Frame of the LiDAR in tf, from whose position points were measured; may be empty.")
            .include(&LidarNodeConfig::stage, StageConfig::schema());
    return schema;
  }
};

}  // namespace lidar_mapping::ros_border
