// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>

namespace lidar_mapping::test {

/// Writes what is to stand in the place of a message; false leaves the message as it is.
using WriteMessage = std::function<bool(rosbag::Bag& to, const rosbag::MessageInstance& message)>;
/// Writes what is to stand in the place of a cloud.
using WriteCloud = std::function<void(rosbag::Bag& to, const ros::Time& recorded,
                                      const sensor_msgs::PointCloud2& cloud)>;

/// Copies a bag with other messages.
inline void rewrite_bag(const std::string& from, const std::string& to, const WriteMessage& write) {
  const rosbag::Bag in(from, rosbag::bagmode::Read);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  out.setCompression(rosbag::compression::LZ4);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    if (write(out, message)) continue;
    out.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
  }
  out.close();
}

/// Writes other clouds.
inline WriteMessage for_clouds(const WriteCloud& write) {
  return [write](rosbag::Bag& to, const rosbag::MessageInstance& message) {
    const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (cloud) write(to, message.getTime(), *cloud);
    return cloud != nullptr;
  };
}

}  // namespace lidar_mapping::test
