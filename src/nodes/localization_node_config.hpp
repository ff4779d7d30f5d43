// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/ros/node_config.hpp"

namespace lidar_mapping::ros_border {

/// Parameters of localization_node: those of loop closing, by which places are verified, and its
/// own.
struct LocalizationNodeConfig {
  NodeFields node;
  loop_closing::LoopClosingConfig stage;
  /// Frame of the LiDAR in tf, from whose position points were measured; may be empty.
  std::string lidar_frame;
  /// Folder of the session that is the map, or a folder with latest; empty: load_map names it.
  std::string map;
  /// The vehicle begins near initial_pose; otherwise it finds itself.
  bool use_initial_pose = false;
  /// [m and degrees] Pose of the vehicle in the map at the first scan, right to some metres: x y z
  /// roll pitch yaw.
  std::vector<double> initial_pose = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  /// The drive is recorded for save_session. The clouds of all its key frames then lie in a folder
  /// of TMPDIR until the node ends or reads another map.
  bool record_session = false;

  static const config::Schema<LocalizationNodeConfig>& schema() {
    using Config = LocalizationNodeConfig;
    static const auto schema =
        config::Schema<Config>("loop_closing", "Localisation in a finished map")
            .include(&Config::node, NodeFields::schema())
            .include(&Config::stage, loop_closing::LoopClosingConfig::schema())
            .text("lidar_frame", &Config::lidar_frame,
                  "Frame of the LiDAR in tf, from whose position points were measured; may be "
                  "empty.")
            .text("map", &Config::map,
                  "Folder of the session that is the map, or a folder with latest; empty: load_map "
                  "names it.")
            .boolean("use_initial_pose", &Config::use_initial_pose,
                     "The vehicle begins near initial_pose; otherwise it finds itself.")
            .reals("initial_pose", &Config::initial_pose, 6, "m and degrees",
                   "Pose of the vehicle in the map at the first scan, right to some metres: x y z "
                   "roll pitch yaw.")
            .boolean(
                "record_session", &Config::record_session,
                "The drive is recorded for save_session. The clouds of all its key frames then "
                "lie in a folder of TMPDIR until the node ends or reads another map.");
    return schema;
  }
};

}  // namespace lidar_mapping::ros_border
