// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/input_watch.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <sensor_msgs/Imu.h>

#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"
#include "lidar_mapping/ros/silent_topic.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Wall time (s) without scans after which the reason is logged, and logged again when it changes.
/// Chosen: drivers and bags start within it, and a person waits no longer without a word.
constexpr double kSilenceTime = 5.0;
/// Number of searches for sensors on other topics after the first scan. Chosen: drivers, which
/// start one after the other, have done so within a minute.
constexpr int kMaxSearches = 12;

/// Resolved topics that this package publishes.
std::set<std::string> own_topics(const ros::NodeHandle& node) {
  std::set<std::string> own;
  for (const std::string& name : own_outputs()) own.insert(node.resolveName(name));
  return own;
}

OverlookedSensors optional_inputs(const ros::NodeHandle& node) {
  const auto input = [&](const char* name, const std::vector<std::string>& types) {
    return OptionalInput{name, node.resolveName(name), types};
  };
  return {{input("imu", {ros::message_traits::DataType<sensor_msgs::Imu>::value(), kOusterPacket}),
           input("velocity", VelocityMessages::types()), input("gnss", GnssMessages::types())},
          own_topics(node)};
}

/// Types of messages with points.
std::vector<std::string> point_types() {
  std::vector<std::string> types = cloud_type_names();
  types.emplace_back(kOusterPacket);
  return types;
}

/// Topics that are published now. All packets of an Ouster have one type: those of another kind
/// than `kind` are left out, unless their topic is `subscribed`.
ros::master::V_TopicInfo topics_with(const char* kind, const std::string& subscribed) {
  ros::master::V_TopicInfo topics = published_topics();
  const auto is_other = [&](const ros::master::TopicInfo& topic) {
    return topic.datatype == kOusterPacket && topic.name != subscribed &&
           ouster_name(topic.name, kind).empty();
  };
  topics.erase(std::remove_if(topics.begin(), topics.end(), is_other), topics.end());
  return topics;
}

}  // namespace

InputWatch::InputWatch(NodeContext& context)
    : context_(context),
      overlooked_(optional_inputs(context.node)),
      search_worker_([](const std::string& what, const std::string& problem) {
        ROS_WARN_STREAM(what << ": " << problem);
      }),
      searching_(search_worker_.add_channel("looking for sensors", 1)),
      timer_(context.node.createWallTimer(ros::WallDuration(kSilenceTime),
                                          [this](const ros::WallTimerEvent&) { check_inputs(); })) {
}

void InputWatch::check_inputs() {
  if (!has_scans_) return search_worker_.post(searching_, [this] { warn_without_scans(); });
  // The other sensors have had at least as much time to start as the LiDAR.
  if (++searches_ > kMaxSearches || overlooked_.is_complete()) return timer_.stop();
  if (searches_ > 1) search_worker_.post(searching_, [this] { warn_of_overlooked_sensors(); });
}

/// Without this warning a sensor on another topic would be ignored silently, because only the
/// points are required.
void InputWatch::warn_of_overlooked_sensors() {
  for (const auto& [input, line] :
       overlooked_.search(topics_with(kOusterImu, context_.node.resolveName("imu")))) {
    ROS_WARN_STREAM(input << ": " << line);
    context_.diagnostics.set(input, line);
  }
}

void InputWatch::warn_without_scans() {
  if (is_explained_) return;
  const ros::NodeHandle& node = context_.node;
  const std::string points = node.resolveName("points");
  std::string reason = why_silent(points, point_types(), topics_with(kOusterPoints, points),
                                  own_topics(node), "points");
  if (ros::Time::isSimTime() && ros::Time::now().isZero()) {
    reason += "; use_sim_time is set, but nobody publishes /clock: play the bag with --clock";
  }
  warn_of(reason);
}

void InputWatch::explain(const std::string& reason) {
  is_explained_ = true;
  warn_of(reason);
}

void InputWatch::warn_of(const std::string& reason) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (has_scans_ || std::exchange(last_reason_, reason) == reason) return;
  }
  ROS_WARN_STREAM("no scans yet: " << reason);
  context_.diagnostics.set_state(Diagnostics::Level::kWarning, reason);
}

}  // namespace lidar_mapping::ros_border
