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

constexpr char kHeaderText[] =
    "================================================================================\n"
    "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";

}  // namespace lidar_mapping::test

namespace ros {
namespace message_traits {

using lidar_mapping::test::LivoxDriver;
using lidar_mapping::test::LivoxMessage;
using lidar_mapping::test::OtherVelodyneScan;
using lidar_mapping::test::VelodyneScanMessage;

template <LivoxDriver driver>
struct IsMessage<LivoxMessage<driver>> : TrueType {};
template <LivoxDriver driver>
struct HasHeader<LivoxMessage<driver>> : TrueType {};
template <LivoxDriver driver>
struct MD5Sum<LivoxMessage<driver>> {
  static const char* value() { return "e4d6829bdfe657cb6c21a746c86b21a6"; }
  static const char* value(const LivoxMessage<driver>&) { return value(); }
};
template <LivoxDriver driver>
struct DataType<LivoxMessage<driver>> {
  static const char* value() {
    return driver == LivoxDriver::kOne ? "livox_ros_driver/CustomMsg"
                                       : "livox_ros_driver2/CustomMsg";
  }
  static const char* value(const LivoxMessage<driver>&) { return value(); }
};
template <LivoxDriver driver>
struct Definition<LivoxMessage<driver>> {
  static const char* value() {
    static const std::string text =
        std::string(
            "Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\n"
            "uint8[3] rsvd\nCustomPoint[] points\n") +
        lidar_mapping::test::kHeaderText +
        "================================================================================\n"
        "MSG: " +
        (driver == LivoxDriver::kOne ? "livox_ros_driver" : "livox_ros_driver2") +
        "/CustomPoint\nuint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\nuint8 reflectivity\n"
        "uint8 tag\nuint8 line\n";
    return text.c_str();
  }
  static const char* value(const LivoxMessage<driver>&) { return value(); }
};

template <>
struct IsMessage<VelodyneScanMessage> : TrueType {};
template <>
struct HasHeader<VelodyneScanMessage> : TrueType {};
template <>
struct MD5Sum<VelodyneScanMessage> {
  static const char* value() { return "50804fc9533a0e579e6322c04ae70566"; }
  static const char* value(const VelodyneScanMessage&) { return value(); }
};
template <>
struct DataType<VelodyneScanMessage> {
  static const char* value() { return "velodyne_msgs/VelodyneScan"; }
  static const char* value(const VelodyneScanMessage&) { return value(); }
};
template <>
struct Definition<VelodyneScanMessage> {
  static const char* value() {
    static const std::string text =
        std::string("Header header\nVelodynePacket[] packets\n") +
        lidar_mapping::test::kHeaderText +
        "================================================================================\n"
        "MSG: velodyne_msgs/VelodynePacket\ntime stamp\nuint8[1206] data\n";
    return text.c_str();
  }
  static const char* value(const VelodyneScanMessage&) { return value(); }
};

template <>
struct IsMessage<OtherVelodyneScan> : TrueType {};
template <>
struct HasHeader<OtherVelodyneScan> : TrueType {};
template <>
struct MD5Sum<OtherVelodyneScan> {
  static const char* value() { return "00000000000000000000000000000000"; }
  static const char* value(const OtherVelodyneScan&) { return value(); }
};
template <>
struct DataType<OtherVelodyneScan> : DataType<VelodyneScanMessage> {
  using DataType<VelodyneScanMessage>::value;
  static const char* value(const OtherVelodyneScan&) { return value(); }
};
template <>
struct Definition<OtherVelodyneScan> {
  static const char* value() { return "Header header\n"; }
  static const char* value(const OtherVelodyneScan&) { return value(); }
};

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
