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

/// A bag, or a folder of scans with its content.
struct RecordedFile {
  std::string name;  ///< without path
  std::uintmax_t bytes = 0;
  std::string digest;  ///< of both ends of a file, of names and sizes in a folder
};

/// Throws FileError if it cannot be read.
RecordedFile recorded_file(const std::filesystem::path& path);

/// Source and command of a session: run.json of its folder.
struct RunRecord {
  std::string software;  ///< name and version
  std::string command;   ///< as it was typed
  std::string date;      ///< of the mapping, UTC
  // Identity of the recording.
  std::vector<RecordedFile> files;
  Stamp begin = 0;
  Stamp end = 0;
  double start = 0.0;                         ///< length of the beginning that was left out, s
  std::map<std::string, std::string> topics;  ///< by sensor; empty for folders
  double sensor_height = 0.0;                 ///< height of the LiDAR for folders of scans, m
  std::vector<std::string> sensors;           ///< a line about each sensor
  bool is_complete = false;                   ///< whether the recording was mapped to its end
};

/// Reads the record of a folder; empty if there is none, as with sessions of the nodes. Throws
/// InputError naming the file if it is damaged.
std::optional<RunRecord> read_run_record(const std::filesystem::path& session);
/// Throws FileError.
void write_run_record(const std::filesystem::path& session, const RunRecord& record);

/// Difference of the two recordings in words; empty if they are the same. Names of files are
/// ignored, so that a moved recording is recognised.
std::string recording_difference(const RunRecord& session, const RunRecord& given);

/// First parameter in which the stages' texts (YAML) differ; empty if there is no difference.
std::string parameter_difference(const std::map<std::string, std::string>& session,
                                 const std::map<std::string, std::string>& given);

/// Smallest stamp that is a date; smaller ones count from the start of a simulator or a sensor.
/// Chosen: in 1973, before any LiDAR turned.
inline constexpr Stamp kFirstDate = from_seconds(1e8);

/// A time as text, "2011-09-30 12:40:25 UTC".
std::string utc(std::time_t seconds);

}  // namespace lidar_mapping::report
