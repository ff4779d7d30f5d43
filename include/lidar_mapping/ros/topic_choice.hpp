// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// Topic of the IMU that the launch files name where the user names none.
constexpr char kUsualImu[] = "/kitti/oxts/imu";

/// Topics of the sensors; empty if there is none.
struct SensorTopics {
  /// Of the main LiDAR, one of cloud_types(). As a request it may name several with commas between
  /// them, the main one first.
  std::string points;
  std::string imu;                             ///< sensor_msgs/Imu
  std::string velocity;                        ///< one of VelocityMessages::types()
  std::string gnss;                            ///< one of GnssMessages::types()
  std::vector<std::string> other_points = {};  ///< of the other LiDARs on the vehicle

  /// Of points, IMU, velocity and GNSS, the order in which recordings are checked.
  std::vector<std::string> by_sensor() const { return {points, imu, velocity, gnss}; }
  /// All LiDARs' topics as a request.
  std::string all_points() const {
    std::string text = points;
    for (const std::string& topic : other_points) text += "," + topic;
    return text;
  }
};

/// Topics, without namespace, that this package's nodes and its simulator publish with the types of
/// sensors' messages. They may be in a recording, but belong to no sensor.
const std::vector<std::string>& own_outputs();
/// Whether this package publishes the topic, in any namespace.
bool is_own_output(const std::string& topic);

/// The first readable cloud of a topic; empty if there is none.
std::optional<RecordedCloud> first_cloud(const BagSet& bags, const std::string& topic);

/// Topics of that type (package/Name), the one with most messages first. Topics that this package
/// publishes are left out.
std::vector<std::string> topics_of_type(const BagSet& bags, const std::string& type);

/// Topics of cloud_types(), the one most likely of a LiDAR first: clouds whose points have times
/// before those with rings, these before clouds with intensities and those before others (depth
/// cameras, radars), among equals the one with most data. Topics that this package publishes are
/// left out.
std::vector<std::string> cloud_topics(const BagSet& bags);

/// Completes `wanted`: each sensor without a topic gets that of the launch file if the bags have
/// it, else the topic of its type with most messages; for clouds that which is most likely a
/// LiDAR's, see cloud_topics(); for the velocity, where there is none, an odometry whose twist
/// agrees with its poses. Throws InputError if a requested topic does not exist with such a type.
SensorTopics topics_in(const BagSet& bags, SensorTopics wanted = {});

}  // namespace lidar_mapping::ros_border
