// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <ros/serialization.h>

#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// A type of message with one of its definitions, and how a cloud is read from it.
struct MessageReader {
  CloudType type;
  RecordedCloud (*read)(ros::serialization::IStream stream);
};

/// All of them. All code that has to know the types uses this table: a new type is a row of it and
/// the function that the row names. Of several definitions of a type the first is that of ROS 2.
const std::vector<MessageReader>& message_readers();

}  // namespace lidar_mapping::ros_border
