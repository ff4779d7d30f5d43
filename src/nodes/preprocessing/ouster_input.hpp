// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <sensor_msgs/Imu.h>

#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/ouster_feed.hpp"
#include "lidar_mapping/ros/wire_message.hpp"

#include "preprocessing/input_watch.hpp"

namespace lidar_mapping::ros_border {

/// Reads what the driver of an Ouster publishes: packets with points on topic points, and in the
/// same namespace its metadata and the packets of its IMU, which this class subscribes. These are
/// the IMU where the user names none and nothing comes on topic imu.
class OusterInput {
 public:
  /// What is done with what the packets hold, in the worker's thread.
  struct Takers {
    std::function<void(const RecordedCloud&)> cloud;   ///< header.seq is the number of the turn
    std::function<void(const sensor_msgs::Imu&)> imu;  ///< of the topic beside the points
  };

  /// Subscribes at once where topic points has the driver's name, otherwise with the first packet.
  /// Packets of so many scans and so many samples may wait. `context` and `watch` outlive this
  /// object.
  OusterInput(NodeContext& context, InputWatch& watch, int scans, int samples, Takers takers);

  /// Hands a message of topic points to the worker. The thread of the callbacks calls it.
  void post(const boost::shared_ptr<const WireMessage>& packet);

  // The worker's thread calls these.

  /// The sample in a message of topic imu.
  sensor_msgs::Imu imu_in(const WireMessage& packet);
  /// Records that something has come on topic imu.
  void mark_other_imu() { has_other_imu_ = true; }
  /// Takes the last turn, when nothing has come for a while.
  void finish();
  /// Packets that are in no cloud.
  const OusterLosses& losses() const { return feed_.losses(); }

 private:
  std::string beside_points(const char* name) const;
  bool takes_imu_beside_points() const;
  void subscribe_beside_points();
  void add_metadata(const std::string& metadata);
  void add_points(const WireMessage& packet);
  void add_imu(const WireMessage& packet);
  void deliver(const std::optional<RecordedCloud>& cloud);
  void warn_without_metadata();
  void report();

  NodeContext& context_;
  InputWatch& watch_;
  int scans_, samples_;  ///< that may wait
  Takers takers_;
  OusterFeed feed_;
  bool has_other_imu_ = false;
  std::size_t reported_ = 0;                  ///< packets in no cloud that were reported last
  std::optional<Worker::ChannelId> packets_;  ///< once there are subscriptions
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace lidar_mapping::ros_border
