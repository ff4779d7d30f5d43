// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// What this package's nodes, and its simulator, publish with the types of sensors' messages,
/// without namespace: it may be in a recording, and is no sensor.
const std::vector<std::string>& own_outputs();

/// The topic of that type with most messages, not counting what this package publishes; empty if
/// there is none.
std::string busiest_topic(const BagSet& bags, const std::string& type);

/// The first cloud of a topic that can be read; nothing if there is none.
std::optional<RecordedCloud> first_cloud(const BagSet& bags, const std::string& topic);

/// Topics of sensor_msgs/PointCloud2, that which is most likely a LiDAR's first: clouds whose
/// points have times or rings before clouds with intensities and those before others (depth
/// cameras, radars), among equals the one with most data. What this package publishes is left out.
std::vector<std::string> cloud_topics(const BagSet& bags);

}  // namespace lidar_mapping::ros_border
