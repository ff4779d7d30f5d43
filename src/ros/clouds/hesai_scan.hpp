// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/preprocessing/hesai_packets.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

// MD5 sums of PandarScan by its definitions, of which both packages have had each: packets as
// uint8[1500], and as uint8[].
constexpr char kPandarScanInPlaces[] = "96facf9d6e028e0cacbe7058fbabc851";
constexpr char kPandarScanInSizes[] = "70c3ed4f4ae9144323298b04cc2c760b";

/// A message PandarScan of hesai_lidar or pandar_msgs: a turn of the sensor, as packets.
/// hesai_lidar leaves the header empty: the stamp is then that of the first packet, and the frame
/// the name of the model, as the driver's instructions have it. Throws ros::Exception for a damaged
/// message.
RecordedCloud read_pandar_scan(ros::serialization::IStream stream, PacketLayout layout);

/// The packets in the data of such a cloud; they stay where they are.
std::vector<preprocessing::HesaiPacket> hesai_packets(const RecordedCloud& cloud);

}  // namespace lidar_mapping::ros_border
