// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::ros_border {

/// Throws InputError if so many points do not fit into a message: roscpp takes one of more than 1
/// GB for a damaged stream and closes the connection, and sizes in PointCloud2 have 32 bits.
void check_cloud_size(std::size_t points, std::size_t bytes_per_point);

/// to_message(cloud, stamp, frame_id) for a publisher of PointCloud2, which serialises the points
/// directly, so that large clouds are not copied twice. The cloud must not change until publish()
/// has returned.
struct OutgoingCloud {
  /// The points in `frame_id` at `stamp`. Throws InputError if they do not fit into a message.
  OutgoingCloud(const PointCloud& points, Stamp stamp, const std::string& frame_id);

  /// Writes all bytes of the message's data: head.row_step.
  void write_data(std::uint8_t* to) const;

  sensor_msgs::PointCloud2 head;  ///< all but the data
  const PointCloud& cloud;        ///< the points, m
};

}  // namespace lidar_mapping::ros_border

// What roscpp asks of a type of message: on the wire it is a PointCloud2.
namespace ros {

namespace message_traits {

template <>
struct MD5Sum<lidar_mapping::ros_border::OutgoingCloud> {
  static const char* value() { return MD5Sum<sensor_msgs::PointCloud2>::value(); }
  static const char* value(const lidar_mapping::ros_border::OutgoingCloud&) { return value(); }
};

template <>
struct DataType<lidar_mapping::ros_border::OutgoingCloud> {
  static const char* value() { return DataType<sensor_msgs::PointCloud2>::value(); }
  static const char* value(const lidar_mapping::ros_border::OutgoingCloud&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<lidar_mapping::ros_border::OutgoingCloud> {
  template <typename Stream>
  static void write(Stream& stream, const lidar_mapping::ros_border::OutgoingCloud& message) {
    const sensor_msgs::PointCloud2& head = message.head;
    stream.next(head.header);
    stream.next(head.height);
    stream.next(head.width);
    stream.next(head.fields);
    stream.next(head.is_bigendian);
    stream.next(head.point_step);
    stream.next(head.row_step);
    stream.next(head.row_step);  // the bytes of the data: there is one row
    message.write_data(stream.advance(head.row_step));
    stream.next(head.is_dense);
  }

  static std::uint32_t serializedLength(const lidar_mapping::ros_border::OutgoingCloud& message) {
    return serializationLength(message.head) + message.head.row_step;
  }
};

}  // namespace serialization

}  // namespace ros
