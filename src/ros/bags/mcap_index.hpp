// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "lidar_mapping/ros/chunked_recording.hpp"

#include "bags/file_bytes.hpp"
#include "bags/mcap_records.hpp"

namespace lidar_mapping::ros_border {

/// Part of an MCAP file that is read at a time: a chunk, or a run of records outside of chunks.
struct McapSpan {
  std::uint64_t position = 0;   ///< of its first record, bytes
  std::uint64_t end = 0;        ///< behind that record, or the last of the run, bytes
  std::uint64_t index_end = 0;  ///< behind its message indexes, bytes; `end`: there are none
  bool is_run = false;
  Stamp begin = 0;  ///< log time of its first message
  std::set<std::uint16_t> channels;
};

/// What an MCAP file holds, and where.
struct McapIndex {
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;
  std::map<std::uint16_t, std::uint64_t> messages;  ///< by channel
  std::vector<McapSpan> spans;
  std::optional<MissingPart> missing;  ///< of a file that is cut off or damaged
};

/// Reads the summary of a file or, where that is missing, damaged or incomplete, all its records
/// from the front, up to the first that is damaged.
McapIndex mcap_index(const FileBytes& file);

/// The records of a span, decompressed. Throws FileError if they are damaged.
ChunkContent mcap_content(const FileBytes& file, const McapSpan& span, ChunkMemory& memory);

/// Calls `use(const McapRecord&)` for each record of a content. Throws InputError where they end.
template <typename Use>
void for_each_record(ByteRange content, const Use& use) {
  McapReader reader(content);
  while (reader.left() > 0) use(next_mcap_record(reader));
}

}  // namespace lidar_mapping::ros_border
