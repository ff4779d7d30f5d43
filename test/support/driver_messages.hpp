// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

// Messages of drivers whose packages need not be there, for bags that are written by tests.
namespace lidar_mapping::test {

enum class LivoxDriver { kOne, kTwo };

struct LivoxPoint {
  std::uint32_t offset_time = 0;  ///< ns
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  std::uint8_t reflectivity = 0;
  std::uint8_t tag = 0;
  std::uint8_t line = 0;
};

/// livox_ros_driver/CustomMsg and livox_ros_driver2/CustomMsg.
template <LivoxDriver driver>
struct LivoxMessage {
  std_msgs::Header header;
  std::uint64_t timebase = 0;  ///< ns
  std::uint32_t point_num = 0;
  std::uint8_t lidar_id = 0;
  std::array<std::uint8_t, 3> rsvd{};
  std::vector<LivoxPoint> points;
};

struct VelodynePacketMessage {
  ros::Time stamp;
  std::array<std::uint8_t, 1206> data{};
};

/// velodyne_msgs/VelodyneScan.
struct VelodyneScanMessage {
  std_msgs::Header header;
  std::vector<VelodynePacketMessage> packets;
};

/// The same under this name with another definition, for messages that cannot be read.
struct OtherVelodyneScan {
  std_msgs::Header header;
};

/// Definition of a type of message whose text is `fields`, with that of the header and of one more.
inline std::string definition(const std::string& fields, const std::string& other) {
  const std::string line(80, '=');
  return fields + line + "\nMSG: std_msgs/Header\n" +
         ros::message_traits::definition<std_msgs::Header>() + line + "\nMSG: " + other;
}

inline const char* velodyne_definition() {
  static const std::string text =
      definition("Header header\nVelodynePacket[] packets\n",
                 "velodyne_msgs/VelodynePacket\ntime stamp\nuint8[1206] data\n");
  return text.c_str();
}

template <LivoxDriver driver>
const char* livox_definition() {
  static const std::string text = definition(
      "Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
      "CustomPoint[] points\n",
      std::string(driver == LivoxDriver::kOne ? "livox_ros_driver" : "livox_ros_driver2") +
          "/CustomPoint\nuint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
          "uint8 reflectivity\nuint8 tag\nuint8 line\n");
  return text.c_str();
}

}  // namespace lidar_mapping::test

ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(
    lidar_mapping::test::LivoxMessage<lidar_mapping::test::LivoxDriver::kOne>,
    "e4d6829bdfe657cb6c21a746c86b21a6", "livox_ros_driver/CustomMsg",
    lidar_mapping::test::livox_definition<lidar_mapping::test::LivoxDriver::kOne>())
ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(
    lidar_mapping::test::LivoxMessage<lidar_mapping::test::LivoxDriver::kTwo>,
    "e4d6829bdfe657cb6c21a746c86b21a6", "livox_ros_driver2/CustomMsg",
    lidar_mapping::test::livox_definition<lidar_mapping::test::LivoxDriver::kTwo>())
ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(lidar_mapping::test::VelodyneScanMessage,
                                  "50804fc9533a0e579e6322c04ae70566", "velodyne_msgs/VelodyneScan",
                                  lidar_mapping::test::velodyne_definition())
ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(lidar_mapping::test::OtherVelodyneScan,
                                  "00000000000000000000000000000000", "velodyne_msgs/VelodyneScan",
                                  "Header header\n")

namespace ros {
namespace message_traits {

template <lidar_mapping::test::LivoxDriver driver>
struct IsMessage<lidar_mapping::test::LivoxMessage<driver>> : TrueType {};
template <lidar_mapping::test::LivoxDriver driver>
struct HasHeader<lidar_mapping::test::LivoxMessage<driver>> : TrueType {};
template <>
struct IsMessage<lidar_mapping::test::VelodyneScanMessage> : TrueType {};
template <>
struct HasHeader<lidar_mapping::test::VelodyneScanMessage> : TrueType {};
template <>
struct IsMessage<lidar_mapping::test::OtherVelodyneScan> : TrueType {};
template <>
struct HasHeader<lidar_mapping::test::OtherVelodyneScan> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<lidar_mapping::test::LivoxPoint> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.offset_time);
    stream.next(m.x);
    stream.next(m.y);
    stream.next(m.z);
    stream.next(m.reflectivity);
    stream.next(m.tag);
    stream.next(m.line);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <lidar_mapping::test::LivoxDriver driver>
struct Serializer<lidar_mapping::test::LivoxMessage<driver>> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.header);
    stream.next(m.timebase);
    stream.next(m.point_num);
    stream.next(m.lidar_id);
    for (auto& byte : m.rsvd) stream.next(byte);
    stream.next(m.points);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<lidar_mapping::test::VelodynePacketMessage> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.stamp);
    for (auto& byte : m.data) stream.next(byte);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<lidar_mapping::test::VelodyneScanMessage> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.header);
    stream.next(m.packets);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<lidar_mapping::test::OtherVelodyneScan> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.header);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
