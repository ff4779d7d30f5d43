// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/mcap_file.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "lidar_mapping/common/errors.hpp"

#include "bags/cdr_message.hpp"
#include "bags/file_bytes.hpp"
#include "bags/mcap_index.hpp"
#include "bags/ros2_types.hpp"

namespace lidar_mapping::ros_border {

namespace {

const std::string kBegin = "\x89MCAP0\r\n";  // of such a file, by the format
const char* const kRemedy = "copy it again, or try mcap recover";

}  // namespace

bool McapFile::is_one(const std::string& path) {
  return beginning_of(path, kBegin.size()) == kBegin;
}

McapFile::McapFile(const std::string& path, const WantedTopics& topics)
    : path_(path), file_(std::make_unique<FileBytes>(path, "recording", kRemedy)) {
  const McapIndex index = mcap_index(*file_);
  missing_ = index.missing;
  add_connections(index, topics);
  add_places(index);
}

McapFile::~McapFile() = default;

void McapFile::add_connections(const McapIndex& index, const WantedTopics& topics) {
  for (const auto& [id, channel] : index.channels) {
    if (!is_wanted(channel.topic, topics)) continue;
    const auto schema = index.schemas.find(channel.schema);
    const std::string type = schema == index.schemas.end() ? "" : schema->second.name;
    const Ros2Type* known = ros2_type(type);
    if (known != nullptr && channel.encoding != "cdr") {
      file_->fail("topic " + channel.topic + " is serialised as '" + channel.encoding +
                  "', not as cdr");
    }
    const auto messages = index.messages.find(id);
    connections_[id] = ros2_connection(channel.topic, type);
    if (messages != index.messages.end()) connections_[id].messages = messages->second;
    if (known != nullptr) types_[id] = known;
  }
}

/// Those that have messages of the wanted topics.
void McapFile::add_places(const McapIndex& index) {
  for (const McapPlace& place : index.places) {
    const bool is_read = std::any_of(place.channels.begin(), place.channels.end(),
                                     [&](std::uint16_t id) { return types_.count(id) > 0; });
    if (!is_read) continue;
    places_[place.position] = std::make_shared<McapPlace>(place);
    chunks_.push_back({place.position, place.begin});
  }
  std::sort(chunks_.begin(), chunks_.end(), [](const BagChunk& a, const BagChunk& b) {
    return std::tie(a.begin, a.position) < std::tie(b.begin, b.position);
  });
}

std::vector<BagEntry> McapFile::entries(const BagChunk& chunk) {
  const McapPlace& place = *places_.at(chunk.position);
  std::vector<BagEntry> entries = place.index_end > place.end
                                      ? indexed_entries(place)
                                      : entries_of(read(chunk, memory_), place);
  std::sort(entries.begin(), entries.end(), [](const BagEntry& a, const BagEntry& b) {
    return std::tie(a.recorded, a.offset) < std::tie(b.recorded, b.offset);
  });
  return entries;
}

/// By the message indexes behind the chunk.
std::vector<BagEntry> McapFile::indexed_entries(const McapPlace& place) const {
  const std::vector<std::uint8_t> bytes = file_->read(place.end, place.index_end - place.end);
  std::vector<BagEntry> entries;
  try {
    for_each_record({bytes.data(), bytes.size()}, [&](const McapRecord& record) {
      if (!record.is(McapKind::kMessageIndex)) return;
      const McapMessageIndex index = mcap_message_index(record.content);
      if (types_.count(index.channel) == 0) return;
      for (const McapEntry& entry : index.entries) {
        if (entry.offset > std::numeric_limits<std::uint32_t>::max()) {
          throw InputError("an offset is none");
        }
        entries.push_back({entry.logged, static_cast<std::uint32_t>(entry.offset), index.channel});
      }
    });
  } catch (const InputError&) {
    file_->fail("a message index is damaged", place.end);
  }
  return entries;
}

/// By the messages themselves.
std::vector<BagEntry> McapFile::entries_of(const ChunkContent& content,
                                           const McapPlace& place) const {
  std::vector<BagEntry> entries;
  try {
    for_each_record({content.bytes.get(), content.size}, [&](const McapRecord& record) {
      if (!record.is(McapKind::kMessage)) return;
      McapReader reader(record.content);
      const std::uint16_t channel = reader.u16();
      reader.u32();  // its number
      const Stamp logged = reader.time();
      if (types_.count(channel) == 0) return;
      entries.push_back({logged, static_cast<std::uint32_t>(record.position), channel});
    });
  } catch (const InputError&) {
    file_->fail("a chunk is damaged", place.position);
  }
  return entries;
}

ChunkContent McapFile::read(const BagChunk& chunk, ChunkMemory& memory) {
  return mcap_content(*file_, *places_.at(chunk.position), memory);
}

StoredMessage McapFile::message(const ChunkContent& content, const BagEntry& entry) const try {
  if (entry.offset > content.size) throw InputError("a message lies outside of its chunk");
  McapReader chunk({content.bytes.get() + entry.offset, content.size - entry.offset});
  const McapRecord record = next_mcap_record(chunk);
  McapReader reader(record.content);
  if (!record.is(McapKind::kMessage) || reader.u16() != entry.connection) {
    throw InputError("there is no message where the index says so");
  }
  reader.bytes(kMcapMessageHead - sizeof(std::uint16_t));
  const auto data = std::make_shared<std::vector<std::uint8_t>>(
      from_cdr(reader.bytes(reader.left()), types_.at(entry.connection)->layout));
  return {{data->data(), data->size()}, data};
} catch (const InputError& error) {
  throw FileError(path_ + ": on " + connections_.at(entry.connection).topic + " " + error.what());
}

}  // namespace lidar_mapping::ros_border
