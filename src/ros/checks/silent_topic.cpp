// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/silent_topic.hpp"

#include <algorithm>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

std::string why_silent(const std::string& topic, const std::vector<std::string>& types,
                       const ros::master::V_TopicInfo& published, const std::set<std::string>& own,
                       const std::string& remedy) {
  const std::string names = joined(types, " or ");
  std::vector<std::string> others;
  std::vector<std::string> found;  // their types
  for (const ros::master::TopicInfo& other : published) {
    const bool fits = contains(types, other.datatype);
    if (other.name == topic) {
      return fits ? "no message has arrived on " + topic + " yet, although it is published"
                  : topic + " is published as " + other.datatype + ", not as " + names;
    }
    if (!fits || own.count(other.name) > 0) continue;
    others.push_back(other.name);
    if (!contains(found, other.datatype)) found.push_back(other.datatype);
  }
  const std::string problem = "nobody publishes " + topic;
  if (others.empty()) {
    return problem + ", nor another topic of " + names + ": play a bag or start the driver";
  }
  return problem + "; topics of " + joined(found, " or ") +
         " that are published: " + joined(others) + " (choose one with " + remedy + ":=TOPIC)";
}

ros::master::V_TopicInfo published_topics() {
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  std::sort(topics.begin(), topics.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return topics;
}

}  // namespace lidar_mapping::ros_border
