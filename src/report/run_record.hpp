// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::report {

/// A bag, or a folder of scans with all that is in it.
struct RecordedFile {
  std::string name;  ///< without the folders above it
  std::uintmax_t bytes = 0;
  std::string digest;  ///< of both ends of a file, of names and sizes in a folder
};

/// Throws FileError if it cannot be read.
RecordedFile recorded_file(const std::filesystem::path& path);

/// What a session was made of and how: run.json of its folder.
struct RunRecord {
  std::string software;  ///< name and version
  std::string command;   ///< as it was typed
  std::string date;      ///< of the mapping, UTC
  // What tells one recording from another.
  std::vector<RecordedFile> files;
  Stamp begin = 0;
  Stamp end = 0;
  double start = 0.0;                         ///< s that were left out at the beginning
  std::map<std::string, std::string> topics;  ///< by sensor; empty for folders
  double sensor_height = 0.0;                 ///< of folders, m
  std::vector<std::string> sensors;           ///< what was found of each, a line
  bool is_complete = false;                   ///< the recording was mapped to its end
};

/// Nothing where the folder has none, as with sessions of the nodes. Throws InputError naming the
/// file if it is damaged.
std::optional<RunRecord> read_run_record(const std::filesystem::path& session);
/// Throws FileError.
void write_run_record(const std::filesystem::path& session, const RunRecord& record);

/// In what the two recordings differ, in words; empty if they are one and the same. Names of files
/// do not count: a recording that was moved is the same one.
std::string recording_difference(const RunRecord& session, const RunRecord& given);

/// In which parameter the stages' texts (YAML) differ first; empty if in none.
std::string parameter_difference(const std::map<std::string, std::string>& session,
                                 const std::map<std::string, std::string>& given);

/// Instant of the clock, "2011-09-30 12:40:25 UTC".
std::string utc(std::time_t seconds);

}  // namespace lidar_mapping::report
