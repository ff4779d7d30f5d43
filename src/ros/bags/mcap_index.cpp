// SPDX-License-Identifier: BSD-3-Clause
#include "bags/mcap_index.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include <zlib.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

namespace {

constexpr std::uint64_t kMagic = 8;                // bytes at both ends of a file, by the format
constexpr std::uint64_t kFooter = kMcapHead + 20;  // bytes of the record, by the format
constexpr std::uint64_t kSummaryCrc = sizeof(std::uint32_t);  // last bytes of the footer
/// Most bytes of a run of records outside of chunks. Chosen: as much as a chunk usually has.
constexpr std::uint64_t kLongestRun = 1'000'000;
/// Most bytes of a record of schemas, channels or indexes, so that a damaged length does not
/// exhaust the memory. Chosen: far above any; a definition has some kilobytes.
constexpr std::uint64_t kLongestRecord = 50'000'000;

void add_type(const McapRecord& record, McapIndex& index) {
  if (record.is(McapKind::kSchema)) {
    const McapSchema schema = mcap_schema(record.content);
    index.schemas[schema.id] = schema;
  } else if (record.is(McapKind::kChannel)) {
    const McapChannel channel = mcap_channel(record.content);
    index.channels[channel.id] = channel;
  }
}

MissingPart missing(const FileBytes& file, const std::string& reason, Stamp from) {
  return {from, file.error(reason)};
}

// The summary at the end of a file.

/// Where a file has its summary; empty if it has none.
struct SummarySpan {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;  ///< position of the footer
  std::uint32_t crc = 0;  ///< 0: unknown
};

std::optional<SummarySpan> summary_span(const FileBytes& file) {
  if (file.size() < kMagic + kFooter + kMagic) return std::nullopt;
  SummarySpan span;
  span.end = file.size() - kMagic - kFooter;
  const std::vector<std::uint8_t> bytes = file.read(span.end, kFooter);
  McapReader reader({bytes.data(), bytes.size()});
  const std::uint8_t kind = *reader.bytes(1).first;
  const std::uint64_t length = reader.u64();
  if (kind != static_cast<std::uint8_t>(McapKind::kFooter) || length != kFooter - kMcapHead) {
    return std::nullopt;
  }
  span.begin = reader.u64();
  reader.u64();  // where the offsets of the summary begin
  span.crc = reader.u32();
  if (span.begin == 0) return std::nullopt;
  return span;
}

/// By the format, the checksum is that of the summary and of the footer without the checksum.
bool has_right_crc(const SummarySpan& span, const std::vector<std::uint8_t>& bytes) {
  return span.crc == 0 || ::crc32_z(0, bytes.data(), bytes.size() - kSummaryCrc) == span.crc;
}

McapSpan span_of(const McapChunkIndex& chunk, std::uint64_t limit) {
  const bool fits = chunk.position >= kMagic && chunk.length >= kMcapHead &&
                    chunk.length <= limit && chunk.position <= limit - chunk.length &&
                    chunk.index_length <= limit - chunk.position - chunk.length;
  if (!fits) throw InputError("a chunk lies outside of the file");
  McapSpan span;
  span.position = chunk.position;
  span.end = chunk.position + chunk.length;
  span.index_end = span.end + chunk.index_length;
  span.begin = chunk.begin;
  span.channels = {chunk.channels.begin(), chunk.channels.end()};
  return span;
}

/// Whether the summary knows all chunks, and their channels. Of chunks without message indexes it
/// knows none.
bool is_complete(const McapIndex& index, const std::optional<McapStatistics>& statistics) {
  if (!statistics || statistics->chunks != index.spans.size()) return false;
  if (index.spans.empty()) return statistics->messages == 0;
  for (const McapSpan& span : index.spans) {
    if (span.channels.empty()) return false;
    for (const std::uint16_t channel : span.channels) {
      if (index.channels.count(channel) == 0) return false;
    }
  }
  return true;
}

std::optional<McapIndex> index_of(ByteRange summary, std::uint64_t end) {
  McapIndex index;
  std::optional<McapStatistics> statistics;
  for_each_record(summary, [&](const McapRecord& record) {
    add_type(record, index);
    if (record.is(McapKind::kStatistics)) statistics = mcap_statistics(record.content);
    if (record.is(McapKind::kChunkIndex)) {
      index.spans.push_back(span_of(mcap_chunk_index(record.content), end));
    }
  });
  if (!is_complete(index, statistics)) return std::nullopt;
  index.messages = statistics->messages_of;
  return index;
}

/// Empty if the file has no summary, or one that does not know all. Throws InputError if it is
/// damaged.
std::optional<McapIndex> index_of_summary(const FileBytes& file) {
  const auto span = summary_span(file);
  if (!span) return std::nullopt;
  if (span->begin < kMagic || span->begin > span->end)
    throw InputError("it lies outside of the file");
  const std::vector<std::uint8_t> bytes = file.read(span->begin, span->end + kFooter - span->begin);
  if (!has_right_crc(*span, bytes)) throw InputError("its checksum differs");
  return index_of({bytes.data(), bytes.size() - kFooter}, span->begin);
}

// Reading from the front.

/// Finds the spans of all messages, from record to record.
class Scan {
 public:
  explicit Scan(const FileBytes& file) : file_(file) {}

  McapIndex run() {
    try {
      while (!is_over_) add_record();
      end_span();
    } catch (const Error& error) {
      end_span();
      cut(std::string("it is damaged from byte ") + std::to_string(position_) + " on");
    }
    return std::move(index_);
  }

 private:
  /// The record at the position.
  struct Head {
    std::uint8_t kind = 0;
    std::uint64_t end = 0;

    bool is(McapKind other) const { return kind == static_cast<std::uint8_t>(other); }
  };

  Head head() const {
    const std::vector<std::uint8_t> bytes = file_.read(position_, kMcapHead);
    McapReader reader({bytes.data(), bytes.size()});
    Head head;
    head.kind = *reader.bytes(1).first;
    const std::uint64_t length = reader.u64();
    const std::uint64_t left = file_.size() - position_ - kMcapHead;
    if (head.kind == 0) throw InputError("a record is damaged");
    head.end = length > left ? file_.size() + 1 : position_ + kMcapHead + length;
    return head;
  }

  void add_record() {
    if (file_.size() - position_ < kMcapHead) return cut_off();
    const Head record = head();
    if (record.end > file_.size()) return cut_off();
    if (record.is(McapKind::kDataEnd) || record.is(McapKind::kFooter)) {
      is_over_ = true;
      return;
    }
    if (record.is(McapKind::kMessageIndex)) {
      add_message_index(record);
    } else if (record.is(McapKind::kMessage)) {
      add_message(record);
    } else {
      end_span();
      if (record.is(McapKind::kChunk)) begin_chunk(record);
      if (record.is(McapKind::kSchema) || record.is(McapKind::kChannel)) {
        const std::vector<std::uint8_t> bytes = content(record);
        add_type({record.kind, 0, {bytes.data(), bytes.size()}}, index_);
      }
    }
    position_ = record.end;
  }

  std::vector<std::uint8_t> content(const Head& record) const {
    const std::uint64_t size = record.end - position_ - kMcapHead;
    if (size > kLongestRecord) throw InputError("a record is damaged");
    return file_.read(position_ + kMcapHead, size);
  }

  void cut_off() {
    is_over_ = true;
    end_span();
    cut("its end is missing, from byte " + std::to_string(position_) + " on");
  }
  void cut(const std::string& reason) { index_.missing = missing(file_, reason, newest_); }

  void begin_chunk(const Head& record) {
    constexpr std::uint64_t kTimes = 2 * sizeof(std::uint64_t);  // by the format: they come first
    const std::vector<std::uint8_t> bytes = file_.read(position_ + kMcapHead, kTimes);
    McapReader reader({bytes.data(), bytes.size()});
    McapSpan span;
    span.position = position_;
    span.end = span.index_end = record.end;
    span.begin = reader.time();
    chunk_end_ = reader.time();
    span_ = span;
  }

  void add_message_index(const Head& record) {
    if (!span_ || span_->is_run || position_ != span_->index_end) return;
    const std::vector<std::uint8_t> bytes = content(record);
    const McapMessageIndex messages = mcap_message_index({bytes.data(), bytes.size()});
    span_->index_end = record.end;
    if (messages.entries.empty()) return;
    span_->channels.insert(messages.channel);
    counts_[messages.channel] += messages.entries.size();
  }

  void add_message(const Head& record) {
    const bool goes_on = span_ && span_->is_run && record.end - span_->position <= kLongestRun;
    if (!goes_on) {
      end_span();
      span_.emplace();
      span_->is_run = true;
      span_->position = position_;
    }
    const std::vector<std::uint8_t> bytes = file_.read(position_ + kMcapHead, kMcapMessageHead);
    add_message(McapReader({bytes.data(), bytes.size()}));
    span_->end = span_->index_end = record.end;
  }

  void add_message(McapReader reader) {
    const std::uint16_t channel = reader.u16();
    reader.u32();  // its number
    const Stamp logged = reader.time();
    span_->begin = span_->channels.empty() ? logged : std::min(span_->begin, logged);
    span_->channels.insert(channel);
    ++counts_[channel];
    chunk_end_ = std::max(chunk_end_, logged);
  }

  /// A chunk without message indexes, or with messages of channels that are defined in it, is
  /// looked into.
  void end_span() {
    if (!span_) return;
    McapSpan span = std::move(*span_);
    span_.reset();
    std::map<std::uint16_t, std::uint64_t> counts = std::exchange(counts_, {});
    const auto is_known = [&](std::uint16_t id) { return index_.channels.count(id) > 0; };
    const bool has_index = span.index_end > span.end;
    const bool are_known = std::all_of(span.channels.begin(), span.channels.end(), is_known);
    if (!span.is_run && (!has_index || !are_known)) look_into(span, counts);
    for (const auto& [channel, count] : counts) index_.messages[channel] += count;
    newest_ = std::max(newest_, chunk_end_);
    if (!span.channels.empty()) index_.spans.push_back(std::move(span));
  }

  void look_into(McapSpan& span, std::map<std::uint16_t, std::uint64_t>& counts) try {
    const ChunkContent content = mcap_content(file_, span, memory_);
    const bool has_index = span.index_end > span.end;
    for_each_record({content.bytes.get(), content.size}, [&](const McapRecord& record) {
      add_type(record, index_);
      if (has_index || !record.is(McapKind::kMessage)) return;
      const std::uint16_t channel = McapReader(record.content).u16();
      span.channels.insert(channel);
      ++counts[channel];
    });
  } catch (const Error& error) {
    // What has an index is read, and its damage reported, later.
    if (span.index_end == span.end && !index_.missing) {
      index_.missing = MissingPart{newest_, error.what()};
    }
  }

  const FileBytes& file_;
  std::uint64_t position_ = kMagic;
  bool is_over_ = false;
  std::optional<McapSpan> span_;                   ///< to which the next records may still belong
  std::map<std::uint16_t, std::uint64_t> counts_;  ///< messages of that span by channel
  Stamp chunk_end_ = 0;                            ///< of that span
  Stamp newest_ = 0;                               ///< of all spans before
  ChunkMemory memory_;
  McapIndex index_;
};

}  // namespace

McapIndex mcap_index(const FileBytes& file) {
  std::optional<MissingPart> damage;
  try {
    if (auto index = index_of_summary(file)) return *index;
  } catch (const InputError& error) {
    damage = missing(file, std::string("its summary is damaged (") + error.what() + ")", 0);
  }
  McapIndex index = Scan(file).run();
  if (!index.missing) index.missing = damage;
  return index;
}

}  // namespace lidar_mapping::ros_border
