// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

namespace lidar_mapping::ros_border {

/// A field of a point: name, datatype of sensor_msgs/PointField, bytes from the point's beginning.
struct FieldLayout {
  std::string name;
  std::uint8_t datatype;
  std::uint32_t offset;
};

/// Describes `count` points of `point_step` bytes in one row.
void set_layout(sensor_msgs::PointCloud2& message, const std::vector<FieldLayout>& fields,
                std::uint32_t point_step, std::uint32_t count);

}  // namespace lidar_mapping::ros_border
