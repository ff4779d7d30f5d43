// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/overlooked_sensors.hpp"

#include <algorithm>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

namespace {

bool is_published(const std::string& topic, const ros::master::V_TopicInfo& published) {
  return std::any_of(published.begin(), published.end(),
                     [&](const ros::master::TopicInfo& other) { return other.name == topic; });
}

std::string candidates(const OptionalInput& input, const ros::master::V_TopicInfo& published,
                       const std::set<std::string>& own) {
  std::vector<std::string> list;
  for (const ros::master::TopicInfo& other : published) {
    if (!contains(input.types, other.datatype) || own.count(other.name) > 0) continue;
    list.push_back(other.name + " (" + other.datatype + ")");
  }
  return joined(list);
}

}  // namespace

OverlookedSensors::OverlookedSensors(std::vector<OptionalInput> inputs, std::set<std::string> own)
    : inputs_(std::move(inputs)), own_(std::move(own)) {}

void OverlookedSensors::mark_received(const std::string& input) {
  const std::lock_guard<std::mutex> lock(mutex_);
  inputs_.erase(std::remove_if(inputs_.begin(), inputs_.end(),
                               [&](const OptionalInput& other) { return other.name == input; }),
                inputs_.end());
}

std::map<std::string, std::string> OverlookedSensors::search(
    const ros::master::V_TopicInfo& published) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::map<std::string, std::string> lines;
  for (const OptionalInput& input : inputs_) {
    if (is_published(input.topic, published)) continue;
    const std::string list = candidates(input, published, own_);
    if (list.empty()) continue;
    lines[input.name] = "nobody publishes " + input.topic + ", so the map is made without; " +
                        "published and not used: " + list + " (choose one with " + input.name +
                        ":=TOPIC)";
  }
  inputs_.erase(std::remove_if(inputs_.begin(), inputs_.end(),
                               [&](const auto& input) { return lines.count(input.name) > 0; }),
                inputs_.end());
  return lines;
}

bool OverlookedSensors::is_complete() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return inputs_.empty();
}

}  // namespace lidar_mapping::ros_border
