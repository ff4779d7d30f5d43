// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"

#include "bags/bag_chunk.hpp"
#include "bags/file_bytes.hpp"
#include "bags/recording_formats.hpp"

namespace lidar_mapping::ros_border {

namespace {

constexpr char kVersion[] = "#ROSBAG V2.0\n";
constexpr std::size_t kVersionLength = sizeof kVersion - 1;  // by definition: without the zero
constexpr std::size_t kAnyVersionLength = 9;                 // by the format: "#ROSBAG V"
// Bytes that are requested from the disk in advance. Chosen: some chunks of a bag.
constexpr std::uint64_t kAhead = 8'000'000;

/// First bytes of files that were packed as a whole, by their formats, and what unpacks them.
struct Packing {
  std::string_view begin;
  const char* program;
};
constexpr Packing kPackings[] = {{"\x1f\x8b", "gunzip"},
                                 {"BZh", "bunzip2"},
                                 {"\xfd"
                                  "7zXZ",
                                  "unxz"},
                                 {"\x28\xb5\x2f\xfd", "unzstd"},
                                 {"PK\x03\x04", "unzip"}};

/// Why a file that begins so is no bag, and what to do.
std::string no_bag(std::string_view begin) {
  for (const Packing& packing : kPackings) {
    if (begin.substr(0, packing.begin.size()) != packing.begin) continue;
    return std::string("it is packed; unpack it with ") + packing.program;
  }
  return "it is no bag; rosbag info says what one holds";
}

enum Operation : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

/// Times are written as seconds and nanoseconds.
Stamp time_at(const std::uint8_t* bytes) {
  return kNanosecondsPerSecond * number_at<std::uint32_t>(bytes) +
         number_at<std::uint32_t>(bytes + 4);
}

using HeaderFields = std::map<std::string, std::string>;

/// The fields of a header, each with its length and "name=value"; empty if they do not fill the
/// bytes. (ros::Header does not check the lengths and reads past the end.)
std::optional<HeaderFields> header_fields(ByteRange bytes) {
  HeaderFields fields;
  while (bytes.size > 0) {
    std::uint32_t length = 0;
    if (bytes.size < sizeof length) return std::nullopt;
    std::memcpy(&length, bytes.first, sizeof length);
    if (length > bytes.size - sizeof length) return std::nullopt;
    const auto* text = reinterpret_cast<const char*>(bytes.first) + sizeof length;
    const auto* equals = static_cast<const char*>(std::memchr(text, '=', length));
    if (equals == nullptr) return std::nullopt;
    fields[std::string(text, equals)] = std::string(equals + 1, text + length);
    bytes = {bytes.first + sizeof length + length, bytes.size - sizeof length - length};
  }
  return fields;
}

/// Record of a bag: "name=value" fields, and the position of the data after them.
struct Record {
  std::uint64_t position = 0;
  HeaderFields fields;
  std::uint64_t data = 0;
  std::uint32_t size = 0;

  std::uint64_t end() const { return data + size; }
};

/// The path, if there is such a file.
const std::string& of_file(const std::string& path) {
  if (std::filesystem::is_directory(path)) {
    throw FileError("cannot read the bag " + path + ": it is a folder; name the bags in it");
  }
  if (!std::filesystem::is_regular_file(path)) {
    throw FileError("cannot read the bag " + path + ": there is no such file; check its path");
  }
  return path;
}

class BagFile : public ChunkedRecording {
 public:
  BagFile(const std::string& path, const WantedTopics& topics)
      : path_(path), file_(of_file(path), "bag", "try rosbag reindex") {
    if (file_.size() == 0) {
      throw FileError("cannot read the bag " + path + ": it is empty; copy or record it again");
    }
    read_index(topics);
  }

  std::vector<BagEntry> entries(const BagChunk& chunk) override {
    std::vector<BagEntry> entries;
    const Record head = record_at(chunk.position);
    prefetch_from(head.end());
    Record record = record_at(head.end());
    while (is(record, kIndex)) {
      add_entries(record, entries);
      record = record_at(record.end());
    }
    std::sort(entries.begin(), entries.end());
    return entries;
  }

  ChunkContent read(const BagChunk& chunk, ChunkMemory& memory) override {
    const Record record = record_at(chunk.position);
    const auto compression = record.fields.find("compression");
    if (!is(record, kChunk) || compression == record.fields.end()) fail_at(record.position);
    ChunkContent content;
    content.size = number<std::uint32_t>(record, "size");
    if (content.size > largest_content(compression->second, record.size)) {
      file_.fail("a chunk is damaged", record.position);
    }
    content.bytes = memory.take(content.size);
    if (compression->second == "none") {
      if (record.size != content.size) file_.fail("a chunk is damaged", record.position);
      file_.read(record.data, content.bytes.get(), content.size);
      return content;
    }
    compressed_.resize(std::max<std::size_t>(compressed_.size(), record.size));
    file_.read(record.data, compressed_.data(), record.size);
    try {
      decompress(compression->second, {compressed_.data(), record.size}, content.bytes.get(),
                 content.size);
    } catch (const InputError& error) {
      file_.fail(error.what(), record.position);
    }
    return content;
  }

  StoredMessage message(const ChunkContent& content, const BagEntry& entry) const override {
    std::size_t at = entry.offset;
    const auto take = [&]() -> ByteRange {
      constexpr std::size_t kLength = sizeof(std::uint32_t);
      if (at + kLength > content.size) fail("a chunk is damaged");
      const auto length = number_at<std::uint32_t>(content.bytes.get() + at);
      at += kLength;
      if (length > content.size - at) fail("a chunk is damaged");
      at += length;
      return {content.bytes.get() + at - length, length};
    };
    for (;;) {
      const auto fields = header_fields(take());
      const ByteRange data = take();
      const auto operation = fields ? fields->find("op") : HeaderFields::const_iterator();
      if (!fields || operation == fields->end() || operation->second.size() != 1) {
        fail("a chunk is damaged");
      }
      if (operation->second[0] == static_cast<char>(kMessage)) return {data, content.bytes};
      if (operation->second[0] != static_cast<char>(kConnection)) fail("a chunk is damaged");
    }
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { file_.fail(reason); }
  [[noreturn]] void fail_at(std::uint64_t position) const {
    fail("the record at byte " + std::to_string(position) + " is damaged");
  }

  /// What was requested is not requested again, because that costs a look at each of its pages.
  void prefetch_from(std::uint64_t position) {
    const bool continues = position <= prefetched_ && prefetched_ <= position + kAhead;
    if (!continues) prefetched_ = position;
    if (prefetched_ > position + kAhead / 2) return;
    file_.prefetch(prefetched_, position + kAhead - prefetched_);
    prefetched_ = position + kAhead;
  }

  template <typename Number>
  Number number(const Record& record, const std::string& name) const {
    return number_at<Number>(bytes(record, name, sizeof(Number)));
  }
  Stamp time(const Record& record, const std::string& name) const {
    return time_at(bytes(record, name, 8));
  }
  bool is(const Record& record, Operation operation) const {
    return number<std::uint8_t>(record, "op") == operation;
  }
  const std::uint8_t* bytes(const Record& record, const std::string& name,
                            std::size_t expected) const {
    const auto field = record.fields.find(name);
    if (field == record.fields.end() || field->second.size() != expected) fail_at(record.position);
    return reinterpret_cast<const std::uint8_t*>(field->second.data());
  }

  Record record_at(std::uint64_t position) const {
    // Bytes; chosen: far above any header, whose fields are short.
    constexpr std::uint32_t kLongestHeader = 1'000'000;
    std::uint32_t length = 0;
    if (position >= file_.size()) fail("its end is missing");
    file_.read(position, &length, sizeof length);
    if (length > kLongestHeader) fail_at(position);
    std::vector<std::uint8_t> text(length + sizeof(std::uint32_t));
    file_.read(position + sizeof length, text.data(), text.size());
    const auto fields = header_fields({text.data(), length});
    if (!fields) fail_at(position);
    Record record{position, *fields, position + sizeof length + text.size(),
                  number_at<std::uint32_t>(text.data() + length)};
    if (record.end() > file_.size()) {
      fail("its end is missing, within the record at byte " + std::to_string(position));
    }
    return record;
  }

  void read_index(const WantedTopics& topics) {
    char version[kVersionLength] = {};
    file_.read(0, version, std::min<std::uint64_t>(file_.size(), sizeof version));
    if (std::memcmp(version, kVersion, kAnyVersionLength) != 0) {
      throw FileError("cannot read the bag " + path_ + ": " + no_bag({version, sizeof version}));
    }
    if (std::memcmp(version, kVersion, sizeof version) != 0) {
      fail("it is not of version 2.0 (rosbag fix converts it)");
    }
    const Record bag = record_at(kVersionLength);
    if (!is(bag, kBagHeader)) fail_at(bag.position);
    const auto encryptor = bag.fields.find("encryptor");
    if (encryptor != bag.fields.end() && !encryptor->second.empty()) {
      fail("it is encrypted (rosbag decrypt helps)");
    }
    std::uint64_t position = index_position(bag);
    const auto records = number<std::uint32_t>(bag, "conn_count") +
                         std::uint64_t{number<std::uint32_t>(bag, "chunk_count")};
    for (std::uint64_t i = 0; i < records; ++i) {
      const Record record = record_at(position);
      if (is(record, kConnection)) add_connection(record, topics);
      if (is(record, kChunkInfo)) add_chunk(record);
      position = record.end();
    }
    std::sort(chunks_.begin(), chunks_.end());
  }

  /// Position of the index, which a recording that was killed does not have.
  std::uint64_t index_position(const Record& header) const {
    const auto position = number<std::uint64_t>(header, "index_pos");
    if (position == 0) {
      throw FileError(
          "cannot read the bag " + path_ +
          ": it has no index, as its recording was broken off; rosbag reindex makes one");
    }
    if (position < header.end()) fail_at(header.position);
    return position;
  }

  void add_connection(const Record& record, const WantedTopics& topics) {
    const auto topic = record.fields.find("topic");
    if (topic == record.fields.end()) fail_at(record.position);
    if (!is_wanted(topic->second, topics)) return;
    std::vector<std::uint8_t> text(record.size);
    file_.read(record.data, text.data(), text.size());
    const auto fields = header_fields({text.data(), text.size()});
    if (!fields) fail_at(record.position);
    BagConnection& connection = connections_[number<std::uint32_t>(record, "conn")];
    connection.topic = topic->second;
    const auto type = fields->find("type");
    const auto md5sum = fields->find("md5sum");
    if (type != fields->end()) connection.type = type->second;
    if (md5sum != fields->end()) connection.md5sum = md5sum->second;
  }

  /// The data of the record have the number of messages of each connection in the chunk.
  void add_chunk(const Record& record) {
    std::vector<std::uint8_t> counts(record.size / 8 * 8);
    file_.read(record.data, counts.data(), counts.size());
    bool has_wanted = false;
    for (std::size_t i = 0; i < counts.size(); i += 8) {
      const auto connection = connections_.find(number_at<std::uint32_t>(&counts[i]));
      if (connection == connections_.end()) continue;
      connection->second.messages += number_at<std::uint32_t>(&counts[i + 4]);
      has_wanted = true;
    }
    if (!has_wanted) return;
    chunks_.push_back({number<std::uint64_t>(record, "chunk_pos"), time(record, "start_time")});
  }

  void add_entries(const Record& record, std::vector<BagEntry>& entries) const {
    // Bytes of time and offset, by version 1 of index data in bag format 2.0.
    constexpr std::size_t kEntry = 12;
    const auto connection = number<std::uint32_t>(record, "conn");
    if (connections_.count(connection) == 0) return;
    std::vector<std::uint8_t> text(record.size / kEntry * kEntry);
    file_.read(record.data, text.data(), text.size());
    for (std::size_t i = 0; i < text.size(); i += kEntry) {
      if (number_at<std::uint32_t>(&text[i + 4]) >= kNanosecondsPerSecond) fail_at(record.position);
      entries.push_back({time_at(&text[i]), number_at<std::uint32_t>(&text[i + 8]), connection});
    }
  }

  std::string path_;
  FileBytes file_;
  std::uint64_t prefetched_ = 0;  ///< Up to here the file was requested from the disk.
  std::vector<std::uint8_t> compressed_;
};

}  // namespace

std::unique_ptr<ChunkedRecording> open_bag(const std::string& path, const WantedTopics& topics) {
  return std::make_unique<BagFile>(path, topics);
}

}  // namespace lidar_mapping::ros_border
