// SPDX-License-Identifier: BSD-3-Clause
#include "bags/ros2_types.hpp"

#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/geo_point_stamped.hpp"
#include "lidar_mapping/ros/nmea_sentence.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"

namespace lidar_mapping::ros_border {

namespace {

// The fields of the drivers' types, as their definitions have them but for those of the header.
const char* const kHeader = "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
const char* const kLivoxDefinition =
    "Header header\n"
    "uint64 timebase\n"
    "uint32 point_num\n"
    "uint8 lidar_id\n"
    "uint8[3] rsvd\n"
    "CustomPoint[] points\n"
    "MSG: livox_ros_driver2/CustomPoint\n"
    "uint32 offset_time\n"
    "float32 x\n"
    "float32 y\n"
    "float32 z\n"
    "uint8 reflectivity\n"
    "uint8 tag\n"
    "uint8 line\n";
const char* const kVelodyneDefinition =
    "Header header\n"
    "VelodynePacket[] packets\n"
    "MSG: velodyne_msgs/VelodynePacket\n"
    "time stamp\n"
    "uint8[1206] data\n";

const char* const kPandarDefinition =
    "Header header\n"
    "PandarPacket[] packets\n"
    "MSG: pandar_msgs/PandarPacket\n"
    "time stamp\n"
    "uint8[1500] data\n"
    "uint32 size\n";

using Types = std::map<std::string, Ros2Type>;

std::string name_in_ros2(const std::string& ros1_name) {
  std::string name = ros1_name;
  return name.insert(name.find('/'), "/msg");
}

template <typename Message>
void add(Types& types) {
  namespace traits = ros::message_traits;
  const std::string name = traits::DataType<Message>::value();
  types[name_in_ros2(name)] = {name, traits::MD5Sum<Message>::value(),
                               message_layout(traits::Definition<Message>::value())};
}

/// A driver's type, which is known by cloud_types(); of several definitions it is the first one.
void add(Types& types, const std::string& name, const std::string& definition,
         const std::string& ros2_name) {
  for (const CloudType& type : cloud_types()) {
    if (type.name != name) continue;
    types.emplace(ros2_name, Ros2Type{name, type.md5sum, message_layout(definition + kHeader)});
  }
}

Types all_types() {
  Types types;
  add<sensor_msgs::PointCloud2>(types);
  add<sensor_msgs::PointCloud>(types);
  add<sensor_msgs::Imu>(types);
  add<sensor_msgs::NavSatFix>(types);
  add<GeoPointStamped>(types);
  add<NmeaSentence>(types);
  add<geometry_msgs::TwistStamped>(types);
  add<geometry_msgs::TwistWithCovarianceStamped>(types);
  add<nav_msgs::Odometry>(types);
  add<tf2_msgs::TFMessage>(types);
  add<std_msgs::String>(types);
  // The first driver for ROS 2 has another package and the same fields.
  for (const char* name : {"livox_ros_driver2/msg/CustomMsg", "livox_interfaces/msg/CustomMsg"}) {
    add(types, "livox_ros_driver2/CustomMsg", kLivoxDefinition, name);
  }
  add(types, "velodyne_msgs/VelodyneScan", kVelodyneDefinition, "velodyne_msgs/msg/VelodyneScan");
  add(types, "pandar_msgs/PandarScan", kPandarDefinition, "pandar_msgs/msg/PandarScan");
  // The driver for ROS 2 had three packages for its messages.
  for (const char* package : {"ouster_sensor_msgs", "ouster_msgs", "ouster_ros"}) {
    types[package + std::string("/msg/PacketMsg")] = {kOusterPacket, kOusterPacketSum,
                                                      message_layout("uint8[] buf\n")};
  }
  return types;
}

}  // namespace

const Ros2Type* ros2_type(const std::string& name) {
  static const Types types = all_types();
  const auto found = types.find(name);
  return found == types.end() ? nullptr : &found->second;
}

BagConnection ros2_connection(const std::string& topic, const std::string& type) {
  const Ros2Type* known = ros2_type(type);
  if (known == nullptr) return {topic, name_in_ros1(type), "", 0};
  return {topic, known->ros1_name, known->md5sum, 0};
}

std::string name_in_ros1(const std::string& name) {
  const std::string middle = "/msg/";
  const std::size_t at = name.find(middle);
  if (at == std::string::npos) return name;
  return name.substr(0, at) + "/" + name.substr(at + middle.size());
}

}  // namespace lidar_mapping::ros_border
