// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>

// The message of the driver of Ouster, whose package need not be there.
namespace lidar_mapping::test {

/// ouster_ros/PacketMsg.
struct OusterPacketMessage {
  std::vector<std::uint8_t> buf;
};

}  // namespace lidar_mapping::test

namespace ros {
namespace message_traits {

template <>
struct IsMessage<lidar_mapping::test::OusterPacketMessage> : TrueType {};
template <>
struct MD5Sum<lidar_mapping::test::OusterPacketMessage> {
  static const char* value() { return "4f7b5949e76f86d01e96b0e33ba9b5e3"; }
  static const char* value(const lidar_mapping::test::OusterPacketMessage&) { return value(); }
};
template <>
struct DataType<lidar_mapping::test::OusterPacketMessage> {
  static const char* value() { return "ouster_ros/PacketMsg"; }
  static const char* value(const lidar_mapping::test::OusterPacketMessage&) { return value(); }
};
template <>
struct Definition<lidar_mapping::test::OusterPacketMessage> {
  static const char* value() { return "uint8[] buf\n"; }
  static const char* value(const lidar_mapping::test::OusterPacketMessage&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<lidar_mapping::test::OusterPacketMessage> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.buf);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
