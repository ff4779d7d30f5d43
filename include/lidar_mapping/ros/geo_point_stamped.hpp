// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

namespace lidar_mapping::ros_border {

/// geographic_msgs/GeoPointStamped as it is on the wire, which hdl_graph_slam takes for GNSS: its
/// package is not everywhere where ROS is.
struct GeoPointStamped {
  std_msgs::Header header;  ///< stamp of the fix and the antenna's frame
  double latitude = 0.0;    ///< degrees
  double longitude = 0.0;   ///< degrees
  double altitude = 0.0;    ///< m above the WGS 84 ellipsoid; NaN if unknown
};

}  // namespace lidar_mapping::ros_border

// What roscpp asks of a type of message.
ROS_IMPLEMENT_SIMPLE_TOPIC_TRAITS(
    lidar_mapping::ros_border::GeoPointStamped, "ea50d268b03080563c330351a21edc89",
    "geographic_msgs/GeoPointStamped",
    "Header header\n"
    "geographic_msgs/GeoPoint position\n"
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "uint32 seq\n"
    "time stamp\n"
    "string frame_id\n"
    "================================================================================\n"
    "MSG: geographic_msgs/GeoPoint\n"
    "float64 latitude\n"
    "float64 longitude\n"
    "float64 altitude\n")

namespace ros {

template <>
struct message_traits::HasHeader<lidar_mapping::ros_border::GeoPointStamped> : TrueType {};

namespace serialization {

template <>
struct Serializer<lidar_mapping::ros_border::GeoPointStamped> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message m) {
    stream.next(m.header);
    stream.next(m.latitude);
    stream.next(m.longitude);
    stream.next(m.altitude);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
