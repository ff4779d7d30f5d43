// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/ros/bag_set.hpp"

#include "clouds/ouster_turns.hpp"

namespace lidar_mapping::ros_border {

/// Of an Ouster with its metadata the driver's topics of packets stand for clouds and IMU samples:
/// NAME/lidar_packets, NAME/imu_packets and NAME/metadata, by their names. Gives these topics the
/// types of what BagStream makes of their messages.
void present_ouster_packets(std::vector<BagTopic>& topics);

/// Makes clouds and IMU samples of the packets in a stream of messages.
class OusterTopics {
 public:
  /// Reads the metadata and the clocks of the sensors with these topics of packets. What cannot be
  /// used is in problems().
  OusterTopics(const std::vector<std::string>& paths, const std::vector<std::string>& packets);

  /// What is wrong with sensors whose packets are left out, one text each.
  const std::vector<std::string>& problems() const { return problems_; }

  /// Messages that were recorded before `stamp` serve only to complete later ones.
  void begin_at(Stamp stamp) { from_ = stamp; }

  /// A message that is no packet comes back as it is; of packets, what they complete. Throws
  /// InputError or ros::Exception for a damaged packet.
  std::optional<BagMessage> add(const BagMessage& message);
  /// The turns that are left at the end, one at a call.
  std::optional<BagMessage> finish();

  /// Number of packets so far that came when their turn had been given out, and are left out.
  std::size_t late_packets() const;

 private:
  struct Sensor {
    std::optional<OusterTurns> turns;  ///< none if there are no points, or no metadata
    OusterClock clock;
    BagConnection points, imu;  ///< of the messages that are made
  };

  std::optional<BagMessage> made_of(const BagMessage& message);
  void add_sensor(const std::vector<std::string>& paths, const std::string& name);

  std::map<std::string, Sensor> sensors_;  ///< by what their topics begin with
  std::vector<std::string> problems_;
  Stamp from_ = std::numeric_limits<Stamp>::min();
};

}  // namespace lidar_mapping::ros_border
