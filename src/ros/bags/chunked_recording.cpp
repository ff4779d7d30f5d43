// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/chunked_recording.hpp"

#include <algorithm>

#include "lidar_mapping/ros/bag_file.hpp"
#include "lidar_mapping/ros/mcap_file.hpp"

namespace lidar_mapping::ros_border {

bool is_wanted(const std::string& topic, const WantedTopics& wanted) {
  return !wanted || std::find(wanted->begin(), wanted->end(), topic) != wanted->end();
}

std::unique_ptr<ChunkedRecording> open_chunked(const std::string& path,
                                               const WantedTopics& topics) {
  if (McapFile::is_one(path)) return std::make_unique<McapFile>(path, topics);
  return std::make_unique<BagFile>(path, topics);
}

}  // namespace lidar_mapping::ros_border
