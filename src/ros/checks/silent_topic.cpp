// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/silent_topic.hpp"

#include <algorithm>

#include <ros/master.h>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

std::string why_silent(const std::string& topic, const std::vector<std::string>& types,
                       const std::vector<PublishedTopic>& published,
                       const std::set<std::string>& own, const std::string& remedy) {
  const std::string names = joined(types, " or ");
  std::vector<std::string> others;
  std::vector<std::string> found;  // their types
  for (const PublishedTopic& other : published) {
    const bool fits = contains(types, other.type);
    if (other.name == topic) {
      return fits ? "no message has arrived on " + topic + " yet, although it is published"
                  : topic + " is published as " + other.type + ", not as " + names;
    }
    if (!fits || own.count(other.name) > 0) continue;
    others.push_back(other.name);
    if (!contains(found, other.type)) found.push_back(other.type);
  }
  const std::string problem = "nobody publishes " + topic;
  if (others.empty()) {
    return problem + ", nor another topic of " + names + ": play a bag or start the driver";
  }
  return problem + "; topics of " + joined(found, " or ") +
         " that are published: " + joined(others) + " (choose one with " + remedy + ":=TOPIC)";
}

std::vector<PublishedTopic> published_topics() {
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  std::vector<PublishedTopic> result;
  for (const auto& topic : topics) result.push_back({topic.name, topic.datatype});
  std::sort(result.begin(), result.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return result;
}

}  // namespace lidar_mapping::ros_border
