// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/ros/bag_stream.hpp"
#include "lidar_mapping/ros/cloud_view.hpp"

namespace lidar_mapping::ros_border {

/// A cloud that was left where it lies in the recording.
struct RecordedCloud {
  sensor_msgs::PointCloud2 message;  ///< without the data
  ByteRange data;
  std::shared_ptr<const void> memory;

  CloudView view() const { return {message, data.first, data.size}; }
};

/// The message holds a cloud. Throws ros::Exception if it is damaged.
RecordedCloud read_cloud(const BagMessage& recorded);

}  // namespace lidar_mapping::ros_border
