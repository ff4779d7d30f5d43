#include "lidar_mapping/ros/cloud_conversions.hpp"

#include <cmath>
#include <cstring>
#include <optional>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

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

sensor_msgs::PointCloud2 to_message(const PointCloud& cloud, Stamp stamp,
                                    const std::string& frame_id) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = to_ros(stamp);
  message.header.frame_id = frame_id;
  message.fields = {float_field("x", 0), float_field("y", 4), float_field("z", 8),
                    float_field("intensity", 12)};
  if (cloud.has_times()) message.fields.push_back(float_field("time", 16));
  message.point_step = cloud.has_times() ? 20 : 16;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.size());
  message.row_step = message.width * message.point_step;
  message.is_dense = true;
  if (!cloud.has_times()) {  // the points as they lie in memory
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(cloud.points.data());
    message.data.assign(bytes, bytes + message.row_step);
    return message;
  }
  message.data.resize(message.row_step);
  std::uint8_t* out = message.data.data();
  for (std::size_t i = 0; i < cloud.size(); ++i, out += message.point_step) {
    std::memcpy(out, &cloud.points[i], sizeof(Point));
    if (cloud.has_times()) std::memcpy(out + sizeof(Point), &cloud.times[i], sizeof(float));
  }
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
