// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "lidar_mapping/ros/chunked_recording.hpp"

// Each length, offset and count in a file is checked against the data, so that damaged ones are
// safe to read.
namespace lidar_mapping::ros_border {

/// A bag of version 2.0 (wiki.ros.org/Bags/Format/2.0), or these topics of it. Unlike rosbag it
/// leaves messages where they were decompressed.
std::unique_ptr<ChunkedRecording> open_bag(const std::string& path, const WantedTopics& topics);

/// Whether the file begins as an MCAP file does.
bool is_mcap(const std::string& path);

/// A recording of ROS 2 in MCAP (mcap.dev/spec), or these topics of it, with chunks that are
/// uncompressed or compressed by LZ4 or Zstandard. Chunks are found by the summary at the end of
/// the file; where that is missing or damaged, or does not know them, the file is read from the
/// front. Types of message that are alike in ROS 1 are converted, so that nothing of ROS 2 is
/// needed, and have the names and MD5 sums of ROS 1; of others only the names are known, and the
/// sum is empty.
std::unique_ptr<ChunkedRecording> open_mcap(const std::string& path, const WantedTopics& topics);

}  // namespace lidar_mapping::ros_border
