// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/number_bytes.hpp"
#include "lidar_mapping/common/point_field_names.hpp"
#include "lidar_mapping/ros/cloud_view.hpp"

namespace lidar_mapping::ros_border {

// Datatypes of fields of eight bytes, which sensor_msgs lacks, by PCL (pcl/type_traits.h).
constexpr std::uint8_t kPclInt64 = 9;
constexpr std::uint8_t kPclUint64 = 10;

/// A field of a point: name, datatype of sensor_msgs/PointField, bytes from the point's beginning.
struct FieldLayout {
  std::string name;
  std::uint8_t datatype;
  std::uint32_t offset;
};

/// Describes `count` points of `point_step` bytes in one row.
void set_layout(sensor_msgs::PointCloud2& message, const std::vector<FieldLayout>& fields,
                std::uint32_t point_step, std::uint32_t count);

/// Bytes of a number of that type; 0 for an unknown one.
std::size_t size_of(std::uint8_t datatype);

/// The field of that name, or null. Throws InputError if it lies outside of the point.
const sensor_msgs::PointField* find_field(const CloudView& message, const std::string& name);
/// The field with a name that is this one in lower case, or null. Throws InputError as
/// find_field().
const sensor_msgs::PointField* find_field_in_any_case(const CloudView& message,
                                                      const std::string& name);
/// The field of the first name that exists in any case, or null.
template <std::size_t count>
const sensor_msgs::PointField* find_any_field(const CloudView& message,
                                              const std::array<const char*, count>& names) {
  for (const char* name : names) {
    if (const sensor_msgs::PointField* field = find_field_in_any_case(message, name)) return field;
  }
  return nullptr;
}
/// Field x, y or z. Throws InputError if it does not exist or is no floating-point number.
const sensor_msgs::PointField& coordinate_field(const CloudView& message, const std::string& name);
/// "x y z intensity", in the message's order.
std::string field_names(const CloudView& message);

/// Throws InputError for big-endian data and for data that are shorter than the header says.
void check_size(const CloudView& message);
/// Whether there are no bytes between the rows.
bool is_contiguous(const CloudView& message);

/// Calls body(address, index) for every point.
template <typename Body>
void for_each_point(const CloudView& message, const Body& body) {
  std::size_t index = 0;
  for (std::size_t row = 0; row < message.height; ++row) {
    const std::uint8_t* in = message.first + row * message.row_step;
    for (std::size_t column = 0; column < message.width; ++column, in += message.point_step) {
      body(in, index++);
    }
  }
}

/// Calls body(read) with the function that reads numbers of this type.
template <typename Body>
void with_reader(std::uint8_t datatype, const Body& body) {
  switch (datatype) {
    case sensor_msgs::PointField::INT8:
      return body(&number_at<std::int8_t>);
    case sensor_msgs::PointField::UINT8:
      return body(&number_at<std::uint8_t>);
    case sensor_msgs::PointField::INT16:
      return body(&number_at<std::int16_t>);
    case sensor_msgs::PointField::UINT16:
      return body(&number_at<std::uint16_t>);
    case sensor_msgs::PointField::INT32:
      return body(&number_at<std::int32_t>);
    case sensor_msgs::PointField::UINT32:
      return body(&number_at<std::uint32_t>);
    case kPclInt64:
      return body(&number_at<std::int64_t>);
    case kPclUint64:
      return body(&number_at<std::uint64_t>);
    case sensor_msgs::PointField::FLOAT32:
      return body([](const std::uint8_t* address) { return number_at<float>(address); });
    default:
      return body(&number_at<double>);
  }
}

}  // namespace lidar_mapping::ros_border
