// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/time.h>

#include "lidar_mapping/ros/byte_range.hpp"

namespace lidar_mapping::ros_border {

/// A message of any type as it comes over the wire. Unlike topic_tools::ShapeShifter it gives its
/// bytes away, so that they are copied once.
struct WireMessage {
  std::string type;                ///< package/Name
  std::string md5sum;              ///< of the definition
  std::vector<std::uint8_t> data;  ///< serialised
  ros::Time received;              ///< when it came

  /// Where the data lie.
  ByteRange bytes() const { return {data.data(), data.size()}; }
  /// header.seq of a type that begins with a header; 0 if the message is shorter than that.
  std::uint32_t sequence() const {
    std::uint32_t number = 0;
    if (data.size() >= sizeof number) std::memcpy(&number, data.data(), sizeof number);
    return number;
  }
  /// Whether the message is of this type and definition.
  template <typename Message>
  bool is() const {
    return type == ros::message_traits::DataType<Message>::value() &&
           md5sum == ros::message_traits::MD5Sum<Message>::value();
  }
  /// The message, which has to be of this type. Throws ros::Exception if it is damaged.
  template <typename Message>
  Message instantiate() const {
    Message message;
    ros::serialization::IStream stream = stream_of(bytes());
    ros::serialization::deserialize(stream, message);
    return message;
  }
};

}  // namespace lidar_mapping::ros_border

// What roscpp asks of a type of message; "*" stands for any type.
namespace ros {
namespace message_traits {

template <>
struct IsMessage<lidar_mapping::ros_border::WireMessage> : TrueType {};
template <>
struct IsMessage<const lidar_mapping::ros_border::WireMessage> : TrueType {};

template <>
struct DataType<lidar_mapping::ros_border::WireMessage> {
  static const char* value() { return "*"; }
  static const char* value(const lidar_mapping::ros_border::WireMessage& message) {
    return message.type.c_str();
  }
};

template <>
struct MD5Sum<lidar_mapping::ros_border::WireMessage> {
  static const char* value() { return "*"; }
  static const char* value(const lidar_mapping::ros_border::WireMessage& message) {
    return message.md5sum.c_str();
  }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<lidar_mapping::ros_border::WireMessage> {
  template <typename Stream>
  static void read(Stream& stream, lidar_mapping::ros_border::WireMessage& message) {
    const std::uint32_t size = stream.getLength();
    const std::uint8_t* first = stream.advance(size);
    message.data.assign(first, first + size);
  }
};

template <>
struct PreDeserialize<lidar_mapping::ros_border::WireMessage> {
  static void notify(
      const PreDeserializeParams<lidar_mapping::ros_border::WireMessage>& parameters) {
    parameters.message->type = (*parameters.connection_header)["type"];
    parameters.message->md5sum = (*parameters.connection_header)["md5sum"];
    parameters.message->received = ros::Time::now();
  }
};

}  // namespace serialization
}  // namespace ros
