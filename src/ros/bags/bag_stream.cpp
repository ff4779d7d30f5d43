// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/bag_stream.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/ros/ouster_messages.hpp"

#include "inputs/ouster_topics.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Number of chunks that are decompressed at a time: a bag that was written topic by topic needs
/// one for each topic.
constexpr std::ptrdiff_t kContents = 8;

}  // namespace

BagStream::BagStream(const std::vector<std::string>& paths, const std::vector<std::string>& topics,
                     Packets packets) {
  open(paths, topics);
  const std::vector<std::string> of_ousters = topics_of(kOusterPacket);
  if (packets == Packets::kAsTheyAre || of_ousters.empty()) return;
  ousters_ = std::make_shared<OusterTopics>(paths, of_ousters);
  for (const std::string& problem : ousters_->problems()) add_damage(0, FileError(problem));
}

void BagStream::open(const std::vector<std::string>& paths,
                     const std::vector<std::string>& topics) {
  for (const std::string& path : paths) {
    if (Ros2File::is_one(path)) {
      ros2_recordings_.push_back(std::make_unique<Ros2File>(path, topics));
    } else {
      bags_.push_back({open_chunked(path, topics)});
      const std::optional<MissingPart> missing = bags_.back().file->missing_part();
      if (missing) add_damage(missing->from, FileError(missing->reason));
    }
  }
}

/// Names of the topics whose messages are of this type.
std::vector<std::string> BagStream::topics_of(const std::string& type) const {
  std::vector<std::string> topics;
  const auto add = [&](const auto& connections) {
    for (const auto& [id, connection] : connections) {
      if (connection.type == type) topics.push_back(connection.topic);
    }
  };
  for (const Bag& bag : bags_) add(bag.file->connections());
  for (const Ros2Recording& recording : ros2_recordings_) add(recording->connections());
  return topics;
}

std::optional<BagMessage> BagStream::next() {
  if (!ousters_) return next_recorded();
  while (const auto message = next_recorded()) {
    if (auto made = made_of(*message)) return made;
  }
  try {
    return ousters_->finish();
  } catch (const InputError& error) {
    add_damage(0, FileError(error.what()));
    return std::nullopt;
  }
}

/// Nothing for packets that are damaged, or with which nothing is complete.
std::optional<BagMessage> BagStream::made_of(const BagMessage& message) try {
  return ousters_->add(message);
} catch (const InputError& error) {
  add_damage(message.recorded, FileError("on " + message.topic() + " " + error.what()));
  return std::nullopt;
} catch (const ros::Exception&) {
  add_damage(message.recorded, FileError("on " + message.topic() + " a packet is cut off"));
  return std::nullopt;
}

std::optional<BagMessage> BagStream::next_recorded() {
  for (;;) {
    const auto at = earliest();
    const auto [recording, time] = earliest_of_ros2();
    if (at == open_.end() && recording == nullptr) return std::nullopt;
    const bool is_bag =
        recording == nullptr || (at != open_.end() && std::get<0>(at->first) <= time);
    if (auto message = is_bag ? message_at(at) : take_from(*recording)) return message;
  }
}

std::pair<BagStream::Ros2Recording*, Stamp> BagStream::earliest_of_ros2() {
  std::pair<Ros2Recording*, Stamp> earliest = {nullptr, 0};
  for (Ros2Recording& recording : ros2_recordings_) {
    if (!recording) continue;
    std::optional<Stamp> time;
    try {
      time = recording->next_time();
    } catch (const FileError& error) {
      add_damage(0, error);
    }
    if (!time) {
      ended_.push_back(std::move(recording));
    } else if (earliest.first == nullptr || *time < earliest.second) {
      earliest = {&recording, *time};
    }
  }
  return earliest;
}

/// Nothing if the message, or the recording behind it, is damaged.
std::optional<BagMessage> BagStream::take_from(Ros2Recording& recording) {
  Ros2Message taken;
  try {
    taken = recording->next();
  } catch (const FileError& error) {
    add_damage(taken.recorded, error);
    ended_.push_back(std::move(recording));
  }
  if (!taken.damage.empty()) add_damage(taken.recorded, FileError(taken.damage));
  if (!taken.data) return std::nullopt;
  return BagMessage{
      taken.connection, taken.recorded, {taken.data->data(), taken.data->size()}, taken.data};
}

/// The next message of a chunk; nothing if it, or the whole chunk, is damaged.
std::optional<BagMessage> BagStream::message_at(OpenChunks::iterator at) try {
  const ChunkedRecording& file = *bags_[std::get<1>(at->first)].file;
  const BagEntry& entry = at->second.entries[at->second.next];
  const ChunkContent& chunk = content(at);
  const StoredMessage stored = file.message(chunk, entry);
  BagMessage message{&file.connections().at(entry.connection), entry.recorded, stored.data,
                     stored.memory};
  advance(at);
  return message;
} catch (const FileError& error) {
  add_damage(std::get<0>(at->first), error);
  if (at->second.content) {
    advance(at);
  } else {
    open_.erase(at);
  }
  return std::nullopt;
}

void BagStream::add_damage(Stamp stamp, const FileError& error) {
  if (++damage_.places > 1) return;
  damage_.first = stamp;
  damage_.reason = error.what();
}

std::size_t BagStream::late_packets() const { return ousters_ ? ousters_->late_packets() : 0; }

void BagStream::skip_to(Stamp stamp) {
  // s; chosen: longer than any turn, so that one that ends behind the stamp is whole.
  constexpr double kTurn = 1.0;
  if (ousters_) {
    ousters_->begin_at(stamp);
    stamp -= from_seconds(kTurn);
  }
  for (auto at = earliest(); at != open_.end() && std::get<0>(at->first) < stamp; at = earliest()) {
    advance(at);
  }
  for (Ros2Recording& recording : ros2_recordings_) {
    if (recording) recording->skip_to(stamp);
  }
}

BagStream::OpenChunks::iterator BagStream::earliest() {
  for (std::size_t bag = 0; bag < bags_.size(); ++bag) {
    const std::vector<BagChunk>& chunks = bags_[bag].file->chunks();
    std::size_t& next = bags_[bag].next_chunk;
    while (next < chunks.size() &&
           (open_.empty() || chunks[next].begin <= std::get<0>(open_.begin()->first))) {
      open_next_chunk(bag);
    }
  }
  return open_.begin();
}

void BagStream::open_next_chunk(std::size_t bag) try {
  OpenChunk opened;
  opened.chunk = bags_[bag].file->chunks()[bags_[bag].next_chunk++];
  opened.entries = bags_[bag].file->entries(opened.chunk);
  if (opened.entries.empty()) return;
  const ChunkPosition position{opened.entries.front().recorded, bag, opened.chunk.position};
  open_.emplace(position, std::move(opened));
} catch (const FileError& error) {
  add_damage(bags_[bag].file->chunks()[bags_[bag].next_chunk - 1].begin, error);
}

void BagStream::advance(OpenChunks::iterator at) {
  auto node = open_.extract(at);
  OpenChunk& chunk = node.mapped();
  if (++chunk.next == chunk.entries.size()) return;
  std::get<0>(node.key()) = chunk.entries[chunk.next].recorded;
  open_.insert(std::move(node));
}

const ChunkContent& BagStream::content(OpenChunks::iterator at) {
  OpenChunk& chunk = at->second;
  if (!chunk.content) {
    evict_farthest();
    const Bag& bag = bags_[std::get<1>(at->first)];
    chunk.content = bag.file->read(chunk.chunk, memory_);
  }
  return *chunk.content;
}

/// Makes room for one more content. The evicted one, whose next message is the latest, is read
/// again later.
void BagStream::evict_farthest() {
  const auto is_there = [](const auto& open) { return open.second.content.has_value(); };
  if (std::count_if(open_.begin(), open_.end(), is_there) < kContents) return;
  std::find_if(open_.rbegin(), open_.rend(), is_there)->second.content.reset();
}

}  // namespace lidar_mapping::ros_border
