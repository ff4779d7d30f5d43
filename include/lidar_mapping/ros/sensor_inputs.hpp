// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/ros/geo_point_stamped.hpp"
#include "lidar_mapping/ros/nmea_sentence.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

namespace lidar_mapping::ros_border {

/// A sample, and the frame of its sensor as the message names it.
template <typename Sample>
struct SensorInput {
  Sample sample;         ///< in the units of the message and the axes of the frame
  std::string frame_id;  ///< may be empty or have a leading slash
};

/// The sample in a message.
SensorInput<ImuSample> input_of(const sensor_msgs::Imu& message);
/// The velocity in a message.
SensorInput<VelocitySample> input_of(const geometry_msgs::TwistStamped& message);
/// The velocity in a message; its covariance is not used.
SensorInput<VelocitySample> input_of(const geometry_msgs::TwistWithCovarianceStamped& message);
/// The twist of an odometry, in the axes of its child_frame_id.
SensorInput<VelocitySample> input_of(const nav_msgs::Odometry& message);
/// The fix in a message.
SensorInput<GnssFix> input_of(const sensor_msgs::NavSatFix& message);
/// The point as a fix without a covariance.
SensorInput<GnssFix> input_of(const GeoPointStamped& message);
/// The fix in a sentence; nothing in one that holds none, as most do.
std::optional<SensorInput<GnssFix>> input_of(const NmeaSentence& message);

/// The types of message that a sample is read from.
template <typename Sample, typename... Messages>
class SensorMessages {
 public:
  /// Their names: package/Name.
  static const std::vector<std::string>& types() {
    static const std::vector<std::string> names = {
        ros::message_traits::DataType<Messages>::value()...};
    return names;
  }
  /// The data in a message of any type; nothing if it is of another one, or holds nothing.
  /// `AnyMessage` is BagMessage, rosbag::MessageInstance or topic_tools::ShapeShifter.
  template <typename AnyMessage>
  static std::optional<SensorInput<Sample>> read(const AnyMessage& any) {
    std::optional<SensorInput<Sample>> input;
    (read_if<Messages>(any, input), ...);
    return input;
  }

 private:
  template <typename Message, typename AnyMessage>
  static void read_if(const AnyMessage& any, std::optional<SensorInput<Sample>>& input) {
    if (any.getDataType() != ros::message_traits::DataType<Message>::value()) return;
    if (const auto message = any.template instantiate<Message>()) input = input_of(*message);
  }
};

/// Messages that a velocity is read from; of nav_msgs/Odometry it is the twist, in the axes of its
/// child_frame_id. In recordings the first is used as a velocity without request, and an odometry
/// if its twist agrees with its poses: they often hold something else (a velocity in
/// East-North-Up, an odometry that leaves its twist empty).
using VelocityMessages =
    SensorMessages<VelocitySample, geometry_msgs::TwistStamped,
                   geometry_msgs::TwistWithCovarianceStamped, nav_msgs::Odometry>;

/// Messages that fixes are read from; the earlier are preferred. A GeoPoint has neither status nor
/// covariance: it counts as a fix of unknown accuracy. Of NMEA sentences GGA is read.
using GnssMessages = SensorMessages<GnssFix, sensor_msgs::NavSatFix, GeoPointStamped, NmeaSentence>;

}  // namespace lidar_mapping::ros_border
