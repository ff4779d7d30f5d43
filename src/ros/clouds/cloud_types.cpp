// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/cloud_types.hpp"

#include <algorithm>

#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>

namespace lidar_mapping::ros_border {

namespace {

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const CloudType& type : cloud_types()) names.push_back(type.name);
  return names;
}

const CloudType* find(const std::string& name) {
  const std::vector<CloudType>& all = cloud_types();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const CloudType& type) { return type.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

const std::vector<CloudType>& cloud_types() {
  // The MD5 sums of types of drivers are those of the packages' message definitions.
  static const std::string livox = "e4d6829bdfe657cb6c21a746c86b21a6";
  static const std::vector<CloudType> all = {
      {"sensor_msgs/PointCloud2", ros::message_traits::MD5Sum<sensor_msgs::PointCloud2>::value()},
      {"livox_ros_driver/CustomMsg", livox},
      {"livox_ros_driver2/CustomMsg", livox},
      {"velodyne_msgs/VelodyneScan", "50804fc9533a0e579e6322c04ae70566"},
      {"sensor_msgs/PointCloud", ros::message_traits::MD5Sum<sensor_msgs::PointCloud>::value()}};
  return all;
}

const std::vector<std::string>& cloud_type_names() {
  static const std::vector<std::string> all = names();
  return all;
}

bool is_cloud(const std::string& type, const std::string& md5sum) {
  const CloudType* known = find(type);
  return known != nullptr && known->md5sum == md5sum;
}

std::string foreign_definition(const std::string& type, const std::string& md5sum) {
  const CloudType* known = find(type);
  if (known == nullptr || known->md5sum == md5sum) return "";
  return type + " of another definition (MD5 sum " + md5sum + ", read is " + known->md5sum + ")";
}

}  // namespace lidar_mapping::ros_border
