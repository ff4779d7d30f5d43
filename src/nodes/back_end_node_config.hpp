// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/ros/node_config.hpp"

namespace lidar_mapping::ros_border {

/// Parameters of back_end_node.
struct BackEndNodeConfig {
  NodeFields node;
  back_end::BackEndConfig stage;
  /// Folder in which every run gets a folder of its own; ~ is the home folder.
  std::string session_directory = "~/.ros/lidar_mapping";
  /// Session to continue: a folder, or latest; empty creates a new one.
  std::string resume;
  /// Frame of the LiDAR in tf, kept for the removal of moving objects; may be empty.
  std::string lidar_frame;

  static const config::Schema<BackEndNodeConfig>& schema() {
    using Config = BackEndNodeConfig;
    static const auto schema =
        config::Schema<Config>("back_end", back_end::BackEndConfig::schema().summary())
            .include(&Config::node, NodeFields::schema())
            .include(&Config::stage, back_end::BackEndConfig::schema())
            .text("session_directory", &Config::session_directory,
                  "Folder in which every run gets a folder of its own; ~ is the home folder.")
            .alias("data_path", "session_directory")
            .text("resume", &Config::resume,
                  "Session to continue: a folder, or latest; empty creates a new one.")
            .text(
                "lidar_frame", &Config::lidar_frame,
                "Frame of the LiDAR in tf, kept for the removal of moving objects; may be empty.");
    return schema;
  }
};

}  // namespace lidar_mapping::ros_border
