// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include <ros/node_handle.h>

#include "lidar_mapping/ros/node.hpp"

namespace lidar_mapping::ros_border {

/// A publisher that sends its newest `count` messages again to every new subscriber, so that a node
/// that is started late or restarted receives the messages that were sent while it was connecting.
/// Subscribers ignore repeated messages. Any thread may publish.
template <typename Message>
class RepeatingPublisher {
 public:
  /// Advertises `topic`.
  RepeatingPublisher(ros::NodeHandle& node, const std::string& topic, std::uint32_t count)
      : newest_(std::make_shared<Newest>()), count_(count) {
    const auto repeat = [newest = newest_](const ros::SingleSubscriberPublisher& subscriber) {
      const std::lock_guard<std::mutex> lock(newest->mutex);
      for (const auto& message : newest->messages) subscriber.publish(message);
    };
    publisher_ = node.advertise<Message>(topic, kPublisherQueue + count, repeat);
  }

  /// Sends a message now, and again to each later subscriber.
  void publish(Message message) {
    const std::lock_guard<std::mutex> lock(newest_->mutex);
    publisher_.publish(message);
    newest_->messages.push_back(std::move(message));
    if (newest_->messages.size() > count_) newest_->messages.pop_front();
  }

 private:
  struct Newest {
    std::mutex mutex;
    std::deque<Message> messages;
  };

  std::shared_ptr<Newest> newest_;
  std::uint32_t count_;
  ros::Publisher publisher_;
};

}  // namespace lidar_mapping::ros_border
