// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/bag_set.hpp"

#include <algorithm>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "inputs/ouster_topics.hpp"

namespace lidar_mapping::ros_border {

namespace {

using Times = std::optional<std::pair<Stamp, Stamp>>;
using Topics = std::map<std::pair<std::string, std::string>, BagTopic>;

template <typename Connections>
void add(const Connections& connections, Topics& topics) {
  for (const auto& [id, connection] : connections) {
    BagTopic& topic = topics[{connection.topic, connection.type}];
    if (topic.name.empty()) topic = {connection.topic, connection.type, 0, connection.md5sum};
    topic.messages += connection.messages;
  }
}

void extend(Times& times, Stamp first, Stamp last) {
  if (!times) times.emplace(first, last);
  times->first = std::min(times->first, first);
  times->second = std::max(times->second, last);
}

/// Extends the times by those of the messages, which are sorted by time in each chunk.
void extend(Times& times, ChunkedRecording& bag) {
  for (const BagChunk& chunk : bag.chunks()) {
    try {
      const std::vector<BagEntry> entries = bag.entries(chunk);
      if (!entries.empty()) extend(times, entries.front().recorded, entries.back().recorded);
    } catch (const FileError&) {
      // Damage is reported when the messages are read.
    }
  }
}

}  // namespace

BagSet::BagSet(std::vector<std::string> paths) : paths_(std::move(paths)) {
  Topics found;
  for (const std::string& path : paths_) {
    if (Ros2File::is_one(path)) {
      add(Ros2File(path).connections(), found);
    } else {
      add(open_chunked(path)->connections(), found);
    }
  }
  for (const auto& [name, topic] : found) topics_.push_back(topic);
  present_ouster_packets(topics_);
}

bool BagSet::has(const std::string& topic, const std::vector<std::string>& types) const {
  return std::any_of(topics_.begin(), topics_.end(), [&](const BagTopic& there) {
    return there.name == topic && contains(types, there.type);
  });
}

std::optional<std::pair<Stamp, Stamp>> BagSet::times_of(
    const std::vector<std::string>& topics) const {
  Times times;
  for (const std::string& path : paths_) {
    if (!Ros2File::is_one(path)) {
      extend(times, *open_chunked(path, topics));
    } else if (const auto of_file = Ros2File(path, topics).times()) {
      extend(times, of_file->first, of_file->second);
    }
  }
  return times;
}

}  // namespace lidar_mapping::ros_border
