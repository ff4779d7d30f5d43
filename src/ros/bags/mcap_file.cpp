// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include "lidar_mapping/common/errors.hpp"

#include "bags/cdr_message.hpp"
#include "bags/file_bytes.hpp"
#include "bags/mcap_index.hpp"
#include "bags/recording_formats.hpp"
#include "bags/ros2_types.hpp"

namespace lidar_mapping::ros_border {

namespace {

const std::string kBegin = "\x89MCAP0\r\n";  // of such a file, by the format
const char* const kRemedy = "copy it again, or try mcap recover";

class McapFile : public ChunkedRecording {
 public:
  McapFile(const std::string& path, const WantedTopics& topics)
      : path_(path), file_(path, "recording", kRemedy) {
    const McapIndex index = mcap_index(file_);
    missing_ = index.missing;
    add_connections(index, topics);
    add_spans(index);
  }

  std::optional<MissingPart> missing_part() const override { return missing_; }

  std::vector<BagEntry> entries(const BagChunk& chunk) override {
    const McapSpan& span = spans_.at(chunk.position);
    std::vector<BagEntry> entries =
        span.index_end > span.end ? indexed_entries(span) : entries_of(read(chunk, memory_), span);
    std::sort(entries.begin(), entries.end());
    return entries;
  }

  ChunkContent read(const BagChunk& chunk, ChunkMemory& memory) override {
    return mcap_content(file_, spans_.at(chunk.position), memory);
  }

  StoredMessage message(const ChunkContent& content, const BagEntry& entry) const override try {
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

 private:
  void add_connections(const McapIndex& index, const WantedTopics& topics) {
    for (const auto& [id, channel] : index.channels) {
      if (!is_wanted(channel.topic, topics)) continue;
      const auto schema = index.schemas.find(channel.schema);
      const std::string type = schema == index.schemas.end() ? "" : schema->second.name;
      const Ros2Type* known = ros2_type(type);
      // Types of a converted bag of ROS 1 have its names.
      if (channel.encoding == "ros1" || (known != nullptr && channel.encoding != "cdr")) {
        throw FileError("cannot read the recording " + path_ + ": topic " + channel.topic +
                        " is serialised as '" + channel.encoding +
                        "', not as cdr; convert it to a bag, or to a recording of rosbag2");
      }
      const auto messages = index.messages.find(id);
      connections_[id] = ros2_connection(channel.topic, type);
      if (messages != index.messages.end()) connections_[id].messages = messages->second;
      if (known != nullptr) types_[id] = known;
    }
  }

  /// Those that have messages of the wanted topics.
  void add_spans(const McapIndex& index) {
    for (const McapSpan& span : index.spans) {
      const bool is_read = std::any_of(span.channels.begin(), span.channels.end(),
                                       [&](std::uint16_t id) { return types_.count(id) > 0; });
      if (!is_read) continue;
      spans_[span.position] = span;
      chunks_.push_back({span.position, span.begin});
    }
    std::sort(chunks_.begin(), chunks_.end());
  }

  /// By the message indexes behind the chunk.
  std::vector<BagEntry> indexed_entries(const McapSpan& span) const {
    const std::vector<std::uint8_t> bytes = file_.read(span.end, span.index_end - span.end);
    std::vector<BagEntry> entries;
    try {
      for_each_record({bytes.data(), bytes.size()}, [&](const McapRecord& record) {
        if (!record.is(McapKind::kMessageIndex)) return;
        const McapMessageIndex index = mcap_message_index(record.content);
        if (types_.count(index.channel) == 0) return;
        for (const McapEntry& entry : index.entries) {
          if (entry.offset > std::numeric_limits<std::uint32_t>::max()) {
            throw InputError("an offset is too large");
          }
          entries.push_back(
              {entry.logged, static_cast<std::uint32_t>(entry.offset), index.channel});
        }
      });
    } catch (const InputError&) {
      file_.fail("a message index is damaged", span.end);
    }
    return entries;
  }

  /// By the messages themselves.
  std::vector<BagEntry> entries_of(const ChunkContent& content, const McapSpan& span) const {
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
      file_.fail("a chunk is damaged", span.position);
    }
    return entries;
  }

  std::string path_;
  FileBytes file_;
  std::map<std::uint32_t, const Ros2Type*> types_;  ///< those that are read, by channel
  std::map<std::uint64_t, McapSpan> spans_;         ///< by their positions
  std::optional<MissingPart> missing_;
  ChunkMemory memory_;  ///< of chunks without message indexes
};

}  // namespace

bool is_mcap(const std::string& path) { return beginning_of(path, kBegin.size()) == kBegin; }

std::unique_ptr<ChunkedRecording> open_mcap(const std::string& path, const WantedTopics& topics) {
  return std::make_unique<McapFile>(path, topics);
}

}  // namespace lidar_mapping::ros_border
