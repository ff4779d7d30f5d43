// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "lidar_mapping/ros/chunked_recording.hpp"

namespace lidar_mapping::ros_border {

/// A bag of version 2.0 (wiki.ros.org/Bags/Format/2.0), or these topics of it. Unlike rosbag it
/// leaves messages where they were decompressed, and checks each length, offset and count against
/// the data, so that damaged bags are safe to read.
std::unique_ptr<ChunkedRecording> open_bag(const std::string& path, const WantedTopics& topics);

}  // namespace lidar_mapping::ros_border
