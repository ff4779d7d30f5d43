// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

namespace lidar_mapping::ros_border {

/// A PointCloud2 whose data may lie elsewhere than in the message, which is then empty.
struct CloudView {
  CloudView(const sensor_msgs::PointCloud2& message)  // NOLINT: each message is such a view
      : CloudView(message, message.data.data(), message.data.size()) {}
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

  const std_msgs::Header& header;
  std::uint32_t height;
  std::uint32_t width;
  const std::vector<sensor_msgs::PointField>& fields;
  bool is_bigendian;
  std::uint32_t point_step;
  std::uint32_t row_step;
  const std::uint8_t* first;
  std::size_t bytes;
};

}  // namespace lidar_mapping::ros_border
