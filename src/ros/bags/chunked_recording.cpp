// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/chunked_recording.hpp"

#include "lidar_mapping/common/text.hpp"

#include "bags/recording_formats.hpp"

namespace lidar_mapping::ros_border {

bool is_wanted(const std::string& topic, const WantedTopics& wanted) {
  return !wanted || contains(*wanted, topic);
}

std::unique_ptr<ChunkedRecording> open_chunked(const std::string& path,
                                               const WantedTopics& topics) {
  return is_mcap(path) ? open_mcap(path, topics) : open_bag(path, topics);
}

}  // namespace lidar_mapping::ros_border
