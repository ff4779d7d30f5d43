// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::ros_border {

/// A type of message that clouds are read from, by its name and definition: the packages of the
/// drivers that define these types are not needed.
struct CloudType {
  std::string name;    ///< package/Name
  std::string md5sum;  ///< of the definition
};

/// All types of message that clouds are read from.
const std::vector<CloudType>& cloud_types();
/// Their names.
const std::vector<std::string>& cloud_type_names();

/// What to do about messages with a definition that is not read.
constexpr char kForeignRemedy[] =
    "publish the sensor's data as sensor_msgs/PointCloud2 with the driver that defines the type";

/// Whether clouds are read from messages of this type and definition.
bool is_cloud(const std::string& type, const std::string& md5sum);
/// What is wrong with messages that have the name of such a type and another definition; else
/// empty.
std::string foreign_definition(const std::string& type, const std::string& md5sum);

}  // namespace lidar_mapping::ros_border
