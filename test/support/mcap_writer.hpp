// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "ros2_writer.hpp"

// MCAP files as rosbag2 writes them, record by record as the specification has it.
namespace lidar_mapping::test {

/// Numbers little-endian, texts and lists behind their lengths.
class McapBytes {
 public:
  template <typename Number>
  McapBytes& number(Number value) {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      text_.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
    return *this;
  }
  McapBytes& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size()));
    return raw(value);
  }
  McapBytes& raw(const std::string& bytes) {
    text_ += bytes;
    return *this;
  }
  /// A record, and its position.
  std::uint64_t record(std::uint8_t kind, const McapBytes& content) {
    const std::uint64_t position = text_.size();
    number(kind).number(std::uint64_t{content.text_.size()}).raw(content.text_);
    return position;
  }
  const std::string& get() const { return text_; }
  std::size_t size() const { return text_.size(); }

 private:
  std::string text_;
};

struct McapOptions {
  std::string compression;         ///< "", "lz4" or "zstd"
  std::size_t chunk_bytes = 4000;  ///< of the content; 0: no chunks
  bool has_message_indexes = true;
  bool has_summary = true;
  bool has_checksums = true;
};

class McapWriter {
 public:
  explicit McapWriter(std::string path, McapOptions options = {})
      : path_(std::move(path)), options_(std::move(options)) {
    out_.raw(kMagic);
    out_.record(1, McapBytes().text("ros2").text("lidar_mapping's tests"));
  }
  ~McapWriter() {
    if (options_.chunk_bytes > 0) end_chunk();
    out_.record(15, McapBytes().number(std::uint32_t{0}));
    add_summary();
    out_.raw(kMagic);
    std::ofstream(path_, std::ios::binary) << out_.get();
  }
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  template <typename Message>
  void add(const std::string& topic, const ros::Time& recorded, const Message& message) {
    add_bytes(topic, ros2_type<Message>(), recorded, cdr_bytes(message));
  }
  void add_bytes(const std::string& topic, const std::string& type, const ros::Time& recorded,
                 const std::vector<std::uint8_t>& bytes, const std::string& encoding = "cdr") {
    McapBytes& to = options_.chunk_bytes > 0 ? chunk_ : out_;
    const std::uint16_t id = channel(to, topic, type, encoding);
    const std::uint64_t time = recorded.toNSec();
    McapBytes message;
    message.number(id).number(++sequence_).number(time).number(time);
    message.raw({bytes.begin(), bytes.end()});
    const std::uint64_t offset = to.record(5, message);
    begin_ = entries_.empty() ? time : std::min(begin_, time);
    end_ = entries_.empty() ? time : std::max(end_, time);
    entries_[id].push_back({time, offset});
    ++counts_[id];
    if (options_.chunk_bytes > 0 && chunk_.size() > options_.chunk_bytes) end_chunk();
  }
  /// Ends a chunk before its size is reached.
  void end_chunk() {
    if (entries_.empty()) return;
    const std::uint64_t position = out_.record(6, chunk_record());
    const std::uint64_t end = out_.size();
    McapBytes offsets;
    for (const auto& [id, entries] : entries_) {
      if (!options_.has_message_indexes) break;
      McapBytes list;
      for (const auto& [time, offset] : entries) list.number(time).number(offset);
      offsets.number(id).number(out_.record(7, McapBytes().number(id).text(list.get())));
    }
    McapBytes index;
    index.number(begin_).number(end_).number(position).number(end - position);
    index.text(offsets.get()).number(out_.size() - end).text(options_.compression);
    index.number(std::uint64_t{compressed().size()}).number(std::uint64_t{chunk_.size()});
    chunk_indexes_.record(8, index);
    ++chunks_;
    chunk_ = {};
    entries_.clear();
  }

 private:
  inline static const std::string kMagic = "\x89MCAP0\r\n";

  std::uint32_t crc(const std::string& bytes) const {
    const auto* first = reinterpret_cast<const Bytef*>(bytes.data());
    return options_.has_checksums ? static_cast<std::uint32_t>(::crc32_z(0, first, bytes.size()))
                                  : 0;
  }
  std::string compressed() const {
    const std::string& from = chunk_.get();
    std::string to;
    if (options_.compression == "lz4") {
      to.resize(LZ4F_compressFrameBound(from.size(), nullptr));
      to.resize(LZ4F_compressFrame(&to[0], to.size(), from.data(), from.size(), nullptr));
    } else if (options_.compression == "zstd") {
      to.resize(ZSTD_compressBound(from.size()));
      to.resize(ZSTD_compress(&to[0], to.size(), from.data(), from.size(), 1));
    } else {
      to = from;
    }
    return to;
  }
  McapBytes chunk_record() const {
    const std::string records = compressed();
    McapBytes chunk;
    chunk.number(begin_).number(end_).number(std::uint64_t{chunk_.size()});
    chunk.number(crc(chunk_.get())).text(options_.compression);
    return chunk.number(std::uint64_t{records.size()}).raw(records);
  }
  /// Its schema and channel are written before its first message, and again in the summary.
  std::uint16_t channel(McapBytes& to, const std::string& topic, const std::string& type,
                        const std::string& encoding) {
    const auto found = ids_.find(topic);
    if (found != ids_.end()) return found->second;
    const auto id = static_cast<std::uint16_t>(ids_.size() + 1);
    ids_[topic] = id;
    const McapBytes schema = McapBytes().number(id).text(type).text("ros2msg").text("# fields");
    const McapBytes channel = McapBytes().number(id).number(id).text(topic).text(encoding).text("");
    for (McapBytes* bytes : {&to, &types_}) {
      bytes->record(3, schema);
      bytes->record(4, channel);
    }
    return id;
  }
  McapBytes statistics() const {
    McapBytes counts;
    std::uint64_t messages = 0;
    for (const auto& [id, count] : counts_) {
      counts.number(id).number(count);
      messages += count;
    }
    McapBytes statistics;
    statistics.number(messages).number(static_cast<std::uint16_t>(ids_.size()));
    statistics.number(static_cast<std::uint32_t>(ids_.size())).number(std::uint32_t{0});
    statistics.number(std::uint32_t{0}).number(chunks_);
    statistics.number(std::uint64_t{0}).number(std::uint64_t{0}).text(counts.get());
    return statistics;
  }
  void add_summary() {
    McapBytes summary;
    if (options_.has_summary) {
      summary.raw(types_.get()).raw(chunk_indexes_.get()).record(11, statistics());
    }
    const std::uint64_t begin = options_.has_summary ? out_.size() : 0;
    McapBytes front = summary;
    front.number(std::uint8_t{2}).number(std::uint64_t{20}).number(begin).number(std::uint64_t{0});
    out_.raw(front.get()).number(crc(front.get()));
  }

  std::string path_;
  McapOptions options_;
  McapBytes out_, chunk_, types_, chunk_indexes_;
  std::map<std::string, std::uint16_t> ids_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  /// Times and offsets of the messages of the chunk, by channel.
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> entries_;
  std::uint64_t begin_ = 0, end_ = 0;
  std::uint32_t sequence_ = 0, chunks_ = 0;
};

}  // namespace lidar_mapping::test
