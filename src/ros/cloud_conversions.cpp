// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/cloud_conversions.hpp"

#include <cmath>
#include <cstring>
#include <optional>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/outgoing_cloud.hpp"

namespace lidar_mapping::ros_border {

namespace {

sensor_msgs::PointField float_field(const std::string& name, std::uint32_t offset) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = sensor_msgs::PointField::FLOAT32;
  field.count = 1;
  return field;
}

/// Byte offset of a float field in a point; nothing if there is no such field.
std::optional<std::size_t> offset_of(const sensor_msgs::PointCloud2& message,
                                     const std::string& name) {
  for (const auto& field : message.fields) {
    if (field.name != name) continue;
    if (field.datatype != sensor_msgs::PointField::FLOAT32 ||
        field.offset + sizeof(float) > message.point_step) {
      throw InputError("cloud: field '" + name + "' is not a FLOAT32 within the point");
    }
    return field.offset;
  }
  return std::nullopt;
}

std::size_t required_offset(const sensor_msgs::PointCloud2& message, const std::string& name) {
  const auto offset = offset_of(message, name);
  if (!offset) throw InputError("cloud: field '" + name + "' is missing");
  return *offset;
}

float read_float(const std::uint8_t* address) {
  float value;
  std::memcpy(&value, address, sizeof value);
  return value;
}

void check_size(const sensor_msgs::PointCloud2& message) {
  const std::size_t row = std::size_t{message.width} * message.point_step;
  const std::size_t needed =
      message.height == 0 ? 0 : std::size_t{message.row_step} * (message.height - 1) + row;
  if (message.is_bigendian || message.data.size() < needed ||
      (message.height > 1 && message.row_step < row)) {
    throw InputError("cloud: " + std::to_string(message.data.size()) + " bytes of data, " +
                     std::to_string(needed) + " announced, or big-endian");
  }
}

}  // namespace

OutgoingCloud::OutgoingCloud(const PointCloud& points, Stamp stamp, const std::string& frame_id)
    : cloud(points) {
  head.header.stamp = to_ros(stamp);
  head.header.frame_id = frame_id;
  head.fields = {float_field("x", 0), float_field("y", 4), float_field("z", 8),
                 float_field("intensity", 12)};
  if (cloud.has_times()) head.fields.push_back(float_field("time", 16));
  head.point_step = cloud.has_times() ? 20 : 16;
  head.height = 1;
  head.width = static_cast<std::uint32_t>(cloud.size());
  head.row_step = head.width * head.point_step;
  head.is_dense = true;
}

void OutgoingCloud::write_data(std::uint8_t* to) const {
  if (cloud.empty()) return;
  if (!cloud.has_times()) {  // the points as they lie in memory
    std::memcpy(to, cloud.points.data(), head.row_step);
    return;
  }
  for (std::size_t i = 0; i < cloud.size(); ++i, to += head.point_step) {
    std::memcpy(to, &cloud.points[i], sizeof(Point));
    std::memcpy(to + sizeof(Point), &cloud.times[i], sizeof(float));
  }
}

sensor_msgs::PointCloud2 to_message(const PointCloud& cloud, Stamp stamp,
                                    const std::string& frame_id) {
  const OutgoingCloud outgoing(cloud, stamp, frame_id);
  sensor_msgs::PointCloud2 message = outgoing.head;
  message.data.resize(message.row_step);
  outgoing.write_data(message.data.data());
  return message;
}

PointCloud from_message(const sensor_msgs::PointCloud2& message) {
  PointCloud cloud;
  if (message.width == 0 || message.height == 0) return cloud;
  check_size(message);
  const std::size_t x = required_offset(message, "x");
  const std::size_t y = required_offset(message, "y");
  const std::size_t z = required_offset(message, "z");
  const auto intensity = offset_of(message, "intensity");
  const auto time = offset_of(message, "time");
  const std::size_t count = std::size_t{message.width} * message.height;
  cloud.points.reserve(count);
  if (time) cloud.times.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* in = message.data.data() + (i / message.width) * message.row_step +
                             (i % message.width) * message.point_step;
    const Point point{read_float(in + x), read_float(in + y), read_float(in + z),
                      intensity ? read_float(in + *intensity) : 0.0F};
    const float t = time ? read_float(in + *time) : 0.0F;
    if (!point.position().allFinite() || !std::isfinite(t)) continue;
    cloud.points.push_back(point);
    if (time) cloud.times.push_back(t);
  }
  return cloud;
}

}  // namespace lidar_mapping::ros_border
