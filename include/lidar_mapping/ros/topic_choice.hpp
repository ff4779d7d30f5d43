#pragma once

#include <string>
#include <vector>

#include <rosbag/bag.h>

namespace lidar_mapping::ros_border {

/// What this package's nodes, and its simulator, publish with the types of sensors' messages,
/// without namespace: it may be in a recording, and is no sensor.
const std::vector<std::string>& own_outputs();

/// The topic of that type with most messages, not counting what this package publishes; empty if
/// there is none.
std::string busiest_topic(const std::vector<const rosbag::Bag*>& bags, const std::string& type);

/// Topics of sensor_msgs/PointCloud2, that which is most likely a LiDAR's first: clouds whose
/// points have times or rings before clouds with intensities and those before others (depth
/// cameras, radars), among equals the one with most data. What this package publishes is left out.
std::vector<std::string> cloud_topics(const std::vector<const rosbag::Bag*>& bags);

}  // namespace lidar_mapping::ros_border
