// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <vector>

#include <ros/master.h>

namespace lidar_mapping::ros_border {

/// One line for a user whose `topic` is silent: whether it is published at all, and which topics of
/// one of its types are, but for those that this package publishes itself. `remedy` names the
/// argument that chooses the topic.
std::string why_silent(const std::string& topic, const std::vector<std::string>& types,
                       const ros::master::V_TopicInfo& published, const std::set<std::string>& own,
                       const std::string& remedy);

/// Topics that are published now by the record of the master, sorted by name.
ros::master::V_TopicInfo published_topics();

}  // namespace lidar_mapping::ros_border
