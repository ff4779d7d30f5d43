// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "bags/wire_array.hpp"
#include "clouds/driver_messages.hpp"

namespace lidar_mapping::ros_border {

namespace {

using preprocessing::VelodynePacket;

/// Bytes of velodyne_msgs/VelodynePacket by its definition: a time and the packet.
constexpr std::uint32_t kTime = 8;
constexpr std::uint32_t kPacket = kTime + VelodynePacket::kBytes;

}  // namespace

RecordedCloud read_velodyne_scan(ros::serialization::IStream stream) {
  RecordedCloud cloud;
  stream.next(cloud.message.header);
  cloud.data = array_bytes(stream, kPacket);
  cloud.packets = PacketLayout::kVelodyne;
  return cloud;
}

std::vector<VelodynePacket> velodyne_packets(ByteRange data) {
  std::vector<VelodynePacket> packets;
  for (std::size_t at = 0; at < data.size; at += kPacket) {
    ros::Time stamp;
    std::memcpy(&stamp.sec, data.first + at, sizeof stamp.sec);
    std::memcpy(&stamp.nsec, data.first + at + sizeof stamp.sec, sizeof stamp.nsec);
    packets.push_back({from_ros(stamp), data.first + at + kTime});
  }
  return packets;
}

}  // namespace lidar_mapping::ros_border
