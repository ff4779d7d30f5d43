// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/ros/bag_stream.hpp"
#include "lidar_mapping/ros/cloud_view.hpp"

namespace lidar_mapping::ros_border {

/// A cloud whose data stay in the memory of the recording.
struct RecordedCloud {
  sensor_msgs::PointCloud2 message;    ///< without the data
  ByteRange data;                      ///< of the message
  std::shared_ptr<const void> memory;  ///< where the data lie

  /// The cloud with its data; this object has to outlive the view.
  CloudView view() const { return {message, data.first, data.size}; }
};

/// The cloud in a message of type sensor_msgs/PointCloud2. Throws ros::Exception if it is damaged.
RecordedCloud read_cloud(const BagMessage& recorded);

}  // namespace lidar_mapping::ros_border
