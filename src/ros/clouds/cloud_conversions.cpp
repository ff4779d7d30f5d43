// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/cloud_conversions.hpp"

#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/outgoing_cloud.hpp"

#include "clouds/point_fields.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Byte offset of a float field in a point; nothing if there is no such field.
std::optional<std::size_t> offset_of(const CloudView& message, const std::string& name) {
  const sensor_msgs::PointField* field = find_field(message, name);
  if (field == nullptr) return std::nullopt;
  if (field->datatype != sensor_msgs::PointField::FLOAT32) {
    throw InputError("cloud: field '" + name + "' is not a FLOAT32");
  }
  return field->offset;
}

std::size_t required_offset(const CloudView& message, const std::string& name) {
  const auto offset = offset_of(message, name);
  if (!offset) throw InputError("cloud: field '" + name + "' is missing");
  return *offset;
}

}  // namespace

void check_cloud_size(std::size_t points, std::size_t bytes_per_point) {
  // Bytes of the data: 1 GB by the definition of roscpp, less room for the rest. Chosen: far more
  // than a header and the fields have.
  constexpr std::size_t kMostBytes = 999'000'000;
  const std::size_t most = kMostBytes / bytes_per_point;
  if (points <= most) return;
  throw InputError("a cloud of " + std::to_string(points) +
                   " points does not fit into a message, which has room for " +
                   std::to_string(most) + "; a coarser resolution makes it smaller");
}

OutgoingCloud::OutgoingCloud(const PointCloud& points, Stamp stamp, const std::string& frame_id)
    : cloud(points) {
  constexpr std::uint8_t kFloat = sensor_msgs::PointField::FLOAT32;
  std::vector<FieldLayout> fields = {
      {"x", kFloat, 0}, {"y", kFloat, 4}, {"z", kFloat, 8}, {"intensity", kFloat, 12}};
  if (cloud.has_times()) fields.push_back({"time", kFloat, 16});
  const std::uint32_t step = cloud.has_times() ? 20 : 16;
  check_cloud_size(cloud.size(), step);
  head.header = header_of(stamp, frame_id);
  set_layout(head, fields, step, static_cast<std::uint32_t>(cloud.size()));
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
  for_each_point(message, [&](const std::uint8_t* in, std::size_t) {
    const Point point{number_at<float>(in + x), number_at<float>(in + y), number_at<float>(in + z),
                      intensity ? number_at<float>(in + *intensity) : 0.0F};
    const float t = time ? number_at<float>(in + *time) : 0.0F;
    if (!point.position().allFinite() || !std::isfinite(t)) return;
    cloud.points.push_back(point);
    if (time) cloud.times.push_back(t);
  });
  return cloud;
}

}  // namespace lidar_mapping::ros_border
