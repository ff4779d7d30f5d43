// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

namespace lidar_mapping::ros_border {

/// nmea_msgs/Sentence as it is on the wire, which drivers of GNSS receivers publish: its package is
/// not everywhere where ROS is.
struct NmeaSentence {
  std_msgs::Header header;  ///< when the sentence came, and the antenna's frame
  std::string sentence;     ///< one, from $ or ! to the checksum
};

}  // namespace lidar_mapping::ros_border

// What roscpp asks of a type of message.
ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(
    lidar_mapping::ros_border::NmeaSentence, "9f221efc5f4b3bac7ce4af102b32308b",
    "nmea_msgs/Sentence",
    "Header header\n"
    "string sentence\n"
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "uint32 seq\n"
    "time stamp\n"
    "string frame_id\n")

namespace ros {

template <>
struct message_traits::HasHeader<lidar_mapping::ros_border::NmeaSentence> : TrueType {};

namespace serialization {

template <>
struct Serializer<lidar_mapping::ros_border::NmeaSentence> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.header);
    stream.next(m.sentence);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
