// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/point_fields.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

using sensor_msgs::PointField;

std::size_t size_of(std::uint8_t datatype) {
  switch (datatype) {
    case PointField::INT8:
    case PointField::UINT8:
      return 1;
    case PointField::INT16:
    case PointField::UINT16:
      return 2;
    case PointField::INT32:
    case PointField::UINT32:
    case PointField::FLOAT32:
      return 4;
    case PointField::FLOAT64:
    case kPclInt64:
    case kPclUint64:
      return 8;
    default:
      return 0;
  }
}

namespace {

void check_field(const CloudView& message, const PointField& field) {
  const std::size_t size = size_of(field.datatype);
  if (size == 0) {
    throw InputError("cloud: field '" + field.name + "' has the unknown datatype " +
                     std::to_string(field.datatype));
  }
  if (field.offset > message.point_step || size > message.point_step - field.offset) {
    throw InputError("cloud: field '" + field.name + "' lies outside of the point of " +
                     std::to_string(message.point_step) + " bytes");
  }
}

}  // namespace

const PointField* find_field(const CloudView& message, const std::string& name) {
  for (const PointField& field : message.fields) {
    if (field.name != name) continue;
    check_field(message, field);
    return &field;
  }
  return nullptr;
}

const PointField* find_field_in_any_case(const CloudView& message, const std::string& name) {
  for (const PointField& field : message.fields) {
    if (lower_case(field.name) == name) return find_field(message, field.name);
  }
  return nullptr;
}

const PointField& coordinate_field(const CloudView& message, const std::string& name) {
  const PointField* field = find_field(message, name);
  if (field == nullptr) {
    throw InputError("cloud: no field '" + name + "'; the driver must publish x, y and z");
  }
  if (field->datatype != PointField::FLOAT32 && field->datatype != PointField::FLOAT64) {
    throw InputError("cloud: field '" + name + "' is no FLOAT32 or FLOAT64");
  }
  return *field;
}

std::string field_names(const CloudView& message) {
  std::vector<std::string> names;
  for (const PointField& field : message.fields) names.push_back(field.name);
  return joined(names, " ");
}

/// Sizes are compared by division, so that no product of theirs overflows.
void check_size(const CloudView& message) {
  if (message.is_bigendian) {
    throw InputError("cloud: big-endian data; the driver must publish little-endian ones");
  }
  const std::size_t bytes = message.bytes;
  const bool fits = message.point_step > 0 && message.width <= bytes / message.point_step;
  const std::size_t row = fits ? std::size_t{message.width} * message.point_step : 0;
  const bool rows_fit =
      message.height <= 1 || (message.row_step >= row && message.row_step > 0 &&
                              message.height - 1 <= (bytes - row) / message.row_step);
  if (fits && rows_fit) return;
  throw InputError("cloud: " + std::to_string(bytes) + " bytes of data are fewer than " +
                   std::to_string(message.height) + " x " + std::to_string(message.width) +
                   " points need; the message was cut off");
}

void set_layout(sensor_msgs::PointCloud2& message, const std::vector<FieldLayout>& fields,
                std::uint32_t point_step, std::uint32_t count) {
  message.fields.clear();
  for (const FieldLayout& layout : fields) {
    sensor_msgs::PointField field;
    field.name = layout.name;
    field.datatype = layout.datatype;
    field.offset = layout.offset;
    field.count = 1;
    message.fields.push_back(field);
  }
  message.height = 1;
  message.width = count;
  message.point_step = point_step;
  message.row_step = point_step * count;
}

bool is_contiguous(const CloudView& message) {
  return message.height == 1 || message.row_step == std::size_t{message.width} * message.point_step;
}

}  // namespace lidar_mapping::ros_border
