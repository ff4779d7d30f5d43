// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <ros/publisher.h>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"

namespace lidar_mapping::ros_border {

/// Publishes scans and what belongs to them: synced_cloud, synced_imu, synced_velocity, synced_gnss
/// and synced_inputs, all with the stamp of their scan, and gnss_datum (latched).
class SyncedPublisher {
 public:
  /// Advertises the topics. `context` outlives this object.
  SyncedPublisher(NodeContext& context, const NodeFields& frames);

  /// The cloud is sent last. The frame of the antenna and the datum are those of the fixes.
  void publish(const preprocessing::SyncedScan& synced, const std::string& antenna_frame,
               const std::optional<GeodeticDatum>& datum);

 private:
  void publish_datum(Stamp stamp, const std::optional<GeodeticDatum>& datum);

  NodeContext& context_;
  const NodeFields frames_;
  std::optional<GeodeticDatum> datum_;  ///< newest published value
  ros::Publisher cloud_, imu_, velocity_, gnss_, inputs_;
  ros::Publisher gnss_datum_;
};

}  // namespace lidar_mapping::ros_border
