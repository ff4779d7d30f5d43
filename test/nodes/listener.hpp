// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include "connections.hpp"
#include "node_process.hpp"

namespace lidar_mapping::test {

/// s, between messages of send_until(); chosen: as often as most LiDARs send scans.
constexpr double kSendInterval = 0.1;
/// Hz, of wait_within_callback(); chosen: the delay is not noticed, and the load is small.
constexpr double kPollRate = 100.0;

/// Lets messages come in until the condition holds, or `seconds` have passed; says whether it
/// holds.
inline bool wait_until(const std::function<bool()>& condition, double seconds = kPatience) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(seconds);
  while (ros::ok()) {
    if (condition()) return true;
    if (ros::WallTime::now() >= end) return false;
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.01));
  }
  return false;
}

/// Calls `send` every tenth of a second until the condition holds, or `seconds` have passed.
/// Messages come in meanwhile. Says whether the condition holds.
inline bool send_until(const std::function<void()>& send, const std::function<bool()>& condition,
                       double seconds = kPatience) {
  ros::WallTime next = ros::WallTime::now();
  const auto holds = [&] {
    if (condition()) return true;
    if (ros::WallTime::now() < next) return false;
    send();
    next = ros::WallTime::now() + ros::WallDuration(kSendInterval);
    return false;
  };
  return wait_until(holds, seconds);
}

/// As wait_until(), for use within a callback: other callbacks wait until this one is over.
inline bool wait_within_callback(const std::function<bool()>& condition,
                                 double seconds = kPatience) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(seconds);
  ros::WallRate rate(kPollRate);
  while (!condition()) {
    if (ros::WallTime::now() >= end) return false;
    rate.sleep();
  }
  return true;
}

/// Keeps all messages of a topic.
template <typename Message>
class Listener {
 public:
  explicit Listener(const std::string& topic) : topic_(topic) { subscribe(); }

  /// The publisher sends to this listener; Subscriber::getNumPublishers() counts links that are not
  /// up yet, and those to a node that was killed.
  bool connected() const { return is_connected(subscriber_.getTopic()); }
  bool wait_for(std::size_t count, double seconds = kPatience) {
    return wait_until([&] { return messages.size() >= count; }, seconds);
  }

  /// Forgets all messages and subscribes as who comes late; a second listener of this process would
  /// share the connection of the first, so that the publisher would not see it.
  void subscribe_again() {
    subscriber_.shutdown();
    messages.clear();
    subscribe();
  }

  std::vector<Message> messages;

 private:
  void subscribe() {
    subscriber_ = ros::NodeHandle().subscribe<Message>(
        topic_, 1000,
        [this](const boost::shared_ptr<const Message>& message) { messages.push_back(*message); });
  }

  std::string topic_;
  ros::Subscriber subscriber_;
};

/// A publisher that a node has found.
template <typename Message>
ros::Publisher connected_publisher(const std::string& topic) {
  ros::Publisher publisher = ros::NodeHandle().advertise<Message>(topic, 1000);
  EXPECT_TRUE(wait_until([&] { return publisher.getNumSubscribers() > 0; })) << topic;
  return publisher;
}

}  // namespace lidar_mapping::test
