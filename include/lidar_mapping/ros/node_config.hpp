#pragma once

#include <string>

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::ros_border {

/// Parameters that every node has. Topics are remapped as always in ROS.
struct NodeFields {
  std::string map_frame = "map";
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  int queue_size = 100;
  static const config::Schema<NodeFields>& schema();
};

/// Configuration of a node whose only parameters beside NodeFields are those of its stage.
template <typename StageConfig>
struct NodeConfig {
  NodeFields node;
  StageConfig stage;

  static const config::Schema<NodeConfig>& schema() {
    static const auto schema =
        config::Schema<NodeConfig>(StageConfig::schema().stage(), StageConfig::schema().summary())
            .include(&NodeConfig::node, NodeFields::schema())
            .include(&NodeConfig::stage, StageConfig::schema());
    return schema;
  }
};

}  // namespace lidar_mapping::ros_border
