// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

namespace lidar_mapping::ros_border {

/// A PointCloud2 whose data may lie elsewhere than in the message, which is then empty.
struct CloudView {
  /// Of a message with its own data, which have to outlive the view.
  CloudView(const sensor_msgs::PointCloud2& message)  // NOLINT: each message is such a view
      : CloudView(message, message.data.data(), message.data.size()) {}
  /// Of a message whose `size` bytes of data lie elsewhere; both have to outlive the view.
  CloudView(const sensor_msgs::PointCloud2& message, const std::uint8_t* data, std::size_t size)
      : header(message.header),
        height(message.height),
        width(message.width),
        fields(message.fields),
        is_bigendian(message.is_bigendian != 0),
        point_step(message.point_step),
        row_step(message.row_step),
        first(data),
        bytes(size) {}

  const std_msgs::Header& header;                      ///< stamp and the sensor's frame
  std::uint32_t height;                                ///< rows of points
  std::uint32_t width;                                 ///< points of a row
  const std::vector<sensor_msgs::PointField>& fields;  ///< of a point
  bool is_bigendian;                                   ///< order of the bytes of a number
  std::uint32_t point_step;                            ///< bytes from point to point
  std::uint32_t row_step;                              ///< bytes from row to row
  const std::uint8_t* first;                           ///< first byte of the data
  std::size_t bytes;                                   ///< length of the data
};

}  // namespace lidar_mapping::ros_border
