// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// The cloud in a message CustomMsg of livox_ros_driver or livox_ros_driver2, which are alike. Its
/// points are a cloud as they lie on the wire. Throws ros::Exception if it is damaged.
RecordedCloud read_livox_cloud(ros::serialization::IStream stream);

}  // namespace lidar_mapping::ros_border
