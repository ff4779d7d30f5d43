// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/preprocessing/hesai_packets.hpp"
#include "lidar_mapping/preprocessing/velodyne_packets.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

// Clouds in messages other than sensor_msgs/PointCloud2. The functions that read a message throw
// ros::Exception if it is damaged; packets stay where they are.
namespace lidar_mapping::ros_border {

/// CustomMsg of livox_ros_driver or livox_ros_driver2, which are alike. Its points are a cloud as
/// they lie on the wire.
RecordedCloud read_livox_cloud(ros::serialization::IStream stream);

/// sensor_msgs/PointCloud: points, and channels beside them, which become fields. Its data are made
/// anew.
RecordedCloud read_point_cloud1(ros::serialization::IStream stream);

/// velodyne_msgs/VelodyneScan: a turn of the sensor, as packets.
RecordedCloud read_velodyne_scan(ros::serialization::IStream stream);
/// The packets in the data of such a cloud.
std::vector<preprocessing::VelodynePacket> velodyne_packets(ByteRange data);

// MD5 sums of PandarScan by its definitions, of which both packages have had each: packets as
// uint8[1500], and as uint8[].
constexpr char kPandarScanInPlaces[] = "96facf9d6e028e0cacbe7058fbabc851";
constexpr char kPandarScanInSizes[] = "70c3ed4f4ae9144323298b04cc2c760b";

/// PandarScan of hesai_lidar or pandar_msgs: a turn of the sensor, as packets. hesai_lidar leaves
/// the header empty: the stamp is then that of the first packet, and the frame the name of the
/// model, as the driver's instructions have it.
RecordedCloud read_pandar_scan(ros::serialization::IStream stream, PacketLayout layout);
/// The packets in the data of such a cloud.
std::vector<preprocessing::HesaiPacket> hesai_packets(const RecordedCloud& cloud);

}  // namespace lidar_mapping::ros_border
