// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/preprocessing/velodyne_packets.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// A message velodyne_msgs/VelodyneScan: a turn of the sensor, as packets. Throws ros::Exception if
/// it is damaged.
RecordedCloud read_velodyne_scan(ros::serialization::IStream stream);

/// The packets in the data of such a cloud; they stay where they are.
std::vector<preprocessing::VelodynePacket> velodyne_packets(ByteRange data);

}  // namespace lidar_mapping::ros_border
