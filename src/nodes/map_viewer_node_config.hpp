// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/ros/node_config.hpp"

namespace lidar_mapping::ros_border {

/// Parameters of map_viewer_node.
struct MapViewerNodeConfig {
  NodeFields node;
  map::MapConfig stage;
  /// [s] Interval (wall clock) at which new key frames are added to the displayed map; 0: with each
  /// key frame. Poses that moved by more than the resolution are shown at once.
  double map_cloud_update_interval = 10.0;

  static const config::Schema<MapViewerNodeConfig>& schema() {
    using Config = MapViewerNodeConfig;
    static const auto schema =
        config::Schema<Config>("map", map::MapConfig::schema().summary())
            .include(&Config::node, NodeFields::schema())
            .include(&Config::stage, map::MapConfig::schema())
            .real(
                "map_cloud_update_interval", &Config::map_cloud_update_interval, {0.0, 3600.0}, "s",
                "Interval (wall clock) at which new key frames are added to the displayed map; "
                "0: with each key frame. Poses that moved by more than the resolution are shown at "
                "once.");
    return schema;
  }
};

}  // namespace lidar_mapping::ros_border
