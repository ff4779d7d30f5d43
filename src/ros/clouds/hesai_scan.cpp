// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "bags/wire_array.hpp"
#include "clouds/driver_messages.hpp"

namespace lidar_mapping::ros_border {

namespace {

using preprocessing::HesaiPacket;
using ros::serialization::IStream;

constexpr std::uint32_t kPlace = 1500;  // bytes for a packet, by the format of pandar_msgs
constexpr std::uint32_t kTime = 8;      // bytes of a time, by the format of ROS messages
constexpr std::uint32_t kNumber = 4;    // bytes of a uint32, by the format of ROS messages

/// A packet, and its time as the message has it.
struct TimedPacket {
  ros::Time stamp;
  HesaiPacket packet;
};

/// Reads PandarPacket: a time, the bytes and their number, which is a second one where the bytes
/// are an array of any length.
TimedPacket next_packet(IStream& stream, PacketLayout layout) {
  TimedPacket result;
  stream.next(result.stamp);
  const bool has_places = layout == PacketLayout::kHesaiInPlaces;
  const ByteRange bytes =
      has_places ? ByteRange{stream.advance(kPlace), kPlace} : array_bytes(stream);
  std::uint32_t number = 0;
  stream.next(number);
  const std::size_t size = has_places ? std::min<std::size_t>(number, kPlace) : bytes.size;
  result.packet = {from_ros(result.stamp), bytes.first, size};
  return result;
}

/// Fills in what the driver leaves out.
void complete(std_msgs::Header& header, const TimedPacket& packet) {
  if (header.stamp.isZero()) header.stamp = packet.stamp;
  if (header.frame_id.empty()) header.frame_id = preprocessing::hesai_model_name(packet.packet);
}

}  // namespace

RecordedCloud read_pandar_scan(IStream stream, PacketLayout layout) {
  RecordedCloud cloud;
  cloud.packets = layout;
  stream.next(cloud.message.header);
  const bool has_places = layout == PacketLayout::kHesaiInPlaces;
  const std::uint32_t count =
      array_length(stream, kTime + kNumber + (has_places ? kPlace : kNumber));
  cloud.data.first = stream.getData();
  for (std::uint32_t i = 0; i < count; ++i) {
    complete(cloud.message.header, next_packet(stream, layout));
  }
  cloud.data.size = static_cast<std::size_t>(stream.getData() - cloud.data.first);
  return cloud;
}

std::vector<HesaiPacket> hesai_packets(const RecordedCloud& cloud) {
  IStream stream = stream_of(cloud.data);
  std::vector<HesaiPacket> packets;
  while (stream.getLength() > 0) packets.push_back(next_packet(stream, cloud.packets).packet);
  return packets;
}

}  // namespace lidar_mapping::ros_border
