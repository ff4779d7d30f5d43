// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// A message sensor_msgs/PointCloud: points, and channels beside them, which become fields. Its
/// data are made anew. Throws ros::Exception if it is damaged.
RecordedCloud read_point_cloud1(ros::serialization::IStream stream);

}  // namespace lidar_mapping::ros_border
