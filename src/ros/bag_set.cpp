// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/bag_set.hpp"

#include <algorithm>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Extends the times by those of the messages of a chunk, which are sorted by time.
void extend(std::optional<std::pair<Stamp, Stamp>>& times, const std::vector<BagEntry>& entries) {
  if (entries.empty()) return;
  const Stamp first = entries.front().recorded;
  const Stamp last = entries.back().recorded;
  if (!times) times.emplace(first, last);
  times->first = std::min(times->first, first);
  times->second = std::max(times->second, last);
}

}  // namespace

BagSet::BagSet(std::vector<std::string> paths) : paths_(std::move(paths)) {
  std::map<std::pair<std::string, std::string>, BagTopic> found;
  for (const std::string& path : paths_) {
    const BagFile bag(path);
    for (const auto& [id, connection] : bag.connections()) {
      BagTopic& topic = found[{connection.topic, connection.type}];
      if (topic.name.empty()) topic = {connection.topic, connection.type, 0, connection.md5sum};
      topic.messages += connection.messages;
    }
  }
  for (const auto& [name, topic] : found) topics_.push_back(topic);
}

bool BagSet::has(const std::string& topic, const std::vector<std::string>& types) const {
  return std::any_of(topics_.begin(), topics_.end(), [&](const BagTopic& there) {
    return there.name == topic && std::find(types.begin(), types.end(), there.type) != types.end();
  });
}

std::optional<std::pair<Stamp, Stamp>> BagSet::times_of(
    const std::vector<std::string>& topics) const {
  std::optional<std::pair<Stamp, Stamp>> times;
  for (const std::string& path : paths_) {
    const BagFile bag(path, topics);
    for (const BagChunk& chunk : bag.chunks()) {
      try {
        extend(times, bag.entries(chunk));
      } catch (const FileError&) {
        // Damage is reported when the messages are read.
      }
    }
  }
  return times;
}

}  // namespace lidar_mapping::ros_border
