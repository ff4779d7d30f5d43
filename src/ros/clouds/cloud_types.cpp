// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/cloud_types.hpp"

#include <algorithm>

#include "lidar_mapping/common/text.hpp"

#include "clouds/message_readers.hpp"

namespace lidar_mapping::ros_border {

namespace {

std::vector<CloudType> types_of_readers() {
  std::vector<CloudType> types;
  for (const MessageReader& reader : message_readers()) types.push_back(reader.type);
  return types;
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const CloudType& type : cloud_types()) {
    if (!contains(names, type.name)) names.push_back(type.name);
  }
  return names;
}

/// The MD5 sums of the definitions that are read under a name.
std::vector<std::string> sums_of(const std::string& name) {
  std::vector<std::string> sums;
  for (const CloudType& type : cloud_types()) {
    if (type.name == name) sums.push_back(type.md5sum);
  }
  return sums;
}

}  // namespace

const std::vector<CloudType>& cloud_types() {
  static const std::vector<CloudType> all = types_of_readers();
  return all;
}

const std::vector<std::string>& cloud_type_names() {
  static const std::vector<std::string> all = names();
  return all;
}

bool is_cloud(const std::string& type, const std::string& md5sum) {
  const std::vector<CloudType>& all = cloud_types();
  return std::any_of(all.begin(), all.end(), [&](const CloudType& known) {
    return known.name == type && known.md5sum == md5sum;
  });
}

std::string foreign_definition(const std::string& type, const std::string& md5sum) {
  const std::vector<std::string> known = sums_of(type);
  if (known.empty() || contains(known, md5sum)) return "";
  // Types of ROS 2 have no sums; those that are read have one of the same fields in ROS 1.
  const std::string found = md5sum.empty() ? "that of ROS 2" : "MD5 sum " + md5sum;
  return type + " of another definition (" + found + ", read is " + joined(known, " or ") + ")";
}

}  // namespace lidar_mapping::ros_border
