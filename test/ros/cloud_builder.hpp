// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

#include "clouds/point_fields.hpp"

/// Clouds as drivers of sensors publish them.
namespace lidar_mapping::test {

using ros_border::FieldLayout;

/// An empty cloud of that layout.
inline sensor_msgs::PointCloud2 cloud_with(const std::vector<FieldLayout>& fields,
                                           std::uint32_t point_step, std::uint32_t count,
                                           const ros::Time& stamp = ros::Time(100, 500000000)) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = stamp;
  message.header.frame_id = "lidar";
  ros_border::set_layout(message, fields, point_step, count);
  message.data.resize(message.row_step);
  return message;
}

template <typename Number>
void put(sensor_msgs::PointCloud2& message, std::size_t index, std::uint32_t offset,
         Number number) {
  std::memcpy(message.data.data() + index * message.point_step + offset, &number, sizeof number);
}

/// Points on a line, so that order and values can be checked: (i, 2 i, 3 i).
inline void put_positions(sensor_msgs::PointCloud2& message) {
  for (std::size_t i = 0; i < message.width; ++i) {
    const auto value = static_cast<float>(i);
    put(message, i, 0, value);
    put(message, i, 4, 2.0F * value);
    put(message, i, 8, 3.0F * value);
  }
}

/// A cloud of such points, with other fields behind their coordinates.
inline sensor_msgs::PointCloud2 xyz_cloud(std::vector<FieldLayout> fields, std::uint32_t point_step,
                                          std::uint32_t count,
                                          const ros::Time& stamp = ros::Time(100, 500000000)) {
  fields.insert(fields.begin(), {{"x", sensor_msgs::PointField::FLOAT32, 0},
                                 {"y", sensor_msgs::PointField::FLOAT32, 4},
                                 {"z", sensor_msgs::PointField::FLOAT32, 8}});
  sensor_msgs::PointCloud2 message = cloud_with(fields, point_step, count, stamp);
  put_positions(message);
  return message;
}

/// A binary PCD file as the message that its driver would have sent.
inline sensor_msgs::PointCloud2 read_pcd(const std::filesystem::path& path,
                                         const ros::Time& stamp) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::string> names;
  std::vector<int> sizes;
  std::vector<char> types;
  std::uint32_t count = 0;
  for (std::string line, key; std::getline(file, line) && key != "DATA";) {
    std::istringstream words(line);
    words >> key;
    for (std::string word; words >> word;) {
      if (key == "FIELDS") names.push_back(word);
      if (key == "SIZE") sizes.push_back(std::stoi(word));
      if (key == "TYPE") types.push_back(word[0]);
      if (key == "POINTS") count = static_cast<std::uint32_t>(std::stoul(word));
    }
    if (key == "DATA") break;
  }
  using Field = sensor_msgs::PointField;
  std::vector<FieldLayout> fields;
  std::uint32_t offset = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::uint8_t datatype = types[i] == 'F'
                                      ? (sizes[i] == 8 ? Field::FLOAT64 : Field::FLOAT32)
                                  : sizes[i] == 4 ? Field::UINT32
                                  : sizes[i] == 2 ? Field::UINT16
                                                  : Field::UINT8;
    fields.push_back({names[i], datatype, offset});
    offset += static_cast<std::uint32_t>(sizes[i]);
  }
  sensor_msgs::PointCloud2 message = cloud_with(fields, offset, count, stamp);
  file.read(reinterpret_cast<char*>(message.data.data()),
            static_cast<std::streamsize>(message.data.size()));
  return message;
}

}  // namespace lidar_mapping::test
