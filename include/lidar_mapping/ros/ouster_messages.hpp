// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <sensor_msgs/Imu.h>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/ros/byte_range.hpp"

namespace lidar_mapping::ros_border {

/// Type of the messages of all packets of an Ouster in ROS 1.
constexpr char kOusterPacket[] = "ouster_ros/PacketMsg";
/// Its MD5 sum, by its definition: "uint8[] buf".
constexpr char kOusterPacketSum[] = "4f7b5949e76f86d01e96b0e33ba9b5e3";

/// Name of the driver's topic of packets with points, behind the sensor's name.
constexpr char kOusterPoints[] = "/lidar_packets";
/// Name of its topic of packets of the IMU.
constexpr char kOusterImu[] = "/imu_packets";
/// Name of its topic of the metadata (std_msgs/String).
constexpr char kOusterMetadata[] = "/metadata";

/// Whether messages of this type and definition hold packets of an Ouster.
bool is_ouster_packet(const std::string& type, const std::string& md5sum);
/// The sensor's name, with which a topic of this kind, one of the names above, begins; empty for
/// topics of another kind.
std::string ouster_name(const std::string& topic, const std::string& kind);

/// The packet in a serialised message, which holds nothing else. Throws ros::Exception if it is cut
/// off.
ByteRange ouster_packet_in(ByteRange message);
/// The sample in a packet of the IMU; the stamp is by the sensor's clock. Throws InputError for a
/// packet of another size or a time that no clock has.
ImuSample ouster_imu_in(ByteRange packet);
/// The sample, whose stamp is by the clock of ROS, in the driver's frame os_imu.
sensor_msgs::Imu ouster_imu_message(const ImuSample& sample);

}  // namespace lidar_mapping::ros_border
