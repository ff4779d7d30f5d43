// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include "connections.hpp"

namespace lidar_mapping::test {

/// Publishes the sensors of a simulated drive under the nodes' own topic names, as fast as they are
/// asked for: what depends on the machine's speed is no test. The frame of the LiDAR has a name
/// that is no default of anything.
class BagPlayer {
 public:
  static constexpr const char* kLidarFrame = "roof_lidar";

  explicit BagPlayer(const std::string& path) {
    rosbag::Bag bag(path, rosbag::bagmode::Read);
    for (const rosbag::MessageInstance& m : rosbag::View(bag)) {
      add<sensor_msgs::PointCloud2>(m, "/kitti/velo/pointcloud", "points");
      add<sensor_msgs::Imu>(m, "/kitti/oxts/imu", "imu");
      add<geometry_msgs::TwistStamped>(m, "/kitti/oxts/gps/vel", "velocity");
      add<sensor_msgs::NavSatFix>(m, "/kitti/oxts/gps/fix", "gnss");
      add<tf2_msgs::TFMessage>(m, "/tf_static", "tf_static", true);
      if (m.getTopic() == "/ground_truth") truth_.push_back(*m.instantiate<nav_msgs::Odometry>());
    }
    bag.close();
  }

  void advertise(const std::vector<std::string>& topics) {
    for (const std::string& topic : topics) publishers_[topic] = advertisers_.at(topic)();
  }
  bool connected() const {
    return std::all_of(publishers_.begin(), publishers_.end(),
                       [](const auto& entry) { return is_connected(entry.first); });
  }
  /// Sends everything up to the scan after the next one, so that no scan waits for a later sample;
  /// false at the end.
  bool send_next_scan() {
    bool has_sent = false;
    for (; next_ < messages_.size(); ++next_) {
      const Entry& entry = messages_[next_];
      if (entry.topic == "points" && std::exchange(has_sent, true)) break;
      const auto publisher = publishers_.find(entry.topic);
      if (publisher != publishers_.end()) entry.publish(publisher->second);
    }
    return has_sent;
  }
  const std::vector<nav_msgs::Odometry>& truth() const { return truth_; }

 private:
  struct Entry {
    std::string topic;
    std::function<void(const ros::Publisher&)> publish;
  };

  template <typename Message>
  static void rename_lidar(Message&) {}
  static void rename_lidar(sensor_msgs::PointCloud2& cloud) { cloud.header.frame_id = kLidarFrame; }
  static void rename_lidar(tf2_msgs::TFMessage& message) {
    for (auto& transform : message.transforms) {
      if (transform.child_frame_id == "velo_link") transform.child_frame_id = kLidarFrame;
    }
  }

  template <typename Message>
  void add(const rosbag::MessageInstance& instance, const std::string& recorded,
           const std::string& topic, bool latched = false) {
    if (instance.getTopic() != recorded) return;
    advertisers_[topic] = [topic, latched] {
      return ros::NodeHandle().advertise<Message>(topic, 1000, latched);
    };
    const auto message = instance.instantiate<Message>();
    rename_lidar(*message);
    messages_.push_back({topic, [message](const ros::Publisher& p) { p.publish(message); }});
  }

  std::vector<Entry> messages_;
  std::size_t next_ = 0;
  std::map<std::string, std::function<ros::Publisher()>> advertisers_;
  std::map<std::string, ros::Publisher> publishers_;
  std::vector<nav_msgs::Odometry> truth_;
};

}  // namespace lidar_mapping::test
