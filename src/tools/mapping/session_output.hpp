// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "lidar_mapping/session/session.hpp"

#include "run_record.hpp"

namespace lidar_mapping::tools {

/// How an existing session in the output folder is treated.
enum class Resume {
  kNo,     ///< not at all: the folder must be new
  kExact,  ///< mapped again from the beginning, with the same bytes as in an uninterrupted run
  kQuick   ///< continued near its end
};

/// The folder that a recording is mapped into. With Resume::kExact the new session is written to a
/// hidden staging folder, and replaces the existing one when it reaches at least as far, so that an
/// interrupted run loses nothing.
class SessionOutput {
 public:
  /// Throws FileError if the folder may not be written to, InputError for a session that a user has
  /// edited and that therefore cannot be mapped again.
  SessionOutput(std::filesystem::path folder, Resume resume);
  ~SessionOutput();
  SessionOutput(const SessionOutput&) = delete;
  SessionOutput& operator=(const SessionOutput&) = delete;

  /// Throws InputError if the existing session was made from another recording or with other
  /// parameters (texts of the stages; those of the map may differ).
  void check(const report::RunRecord& record,
             const std::map<std::string, std::string>& parameters) const;
  /// Whether the existing session has the whole recording.
  bool is_complete() const { return record_ && record_->is_complete; }
  /// Number of key frames of the existing session.
  std::size_t key_frames_before() const { return key_frames_before_; }
  /// Whether there is an existing session that is resumed.
  bool is_resumed() const { return exists_; }

  /// Stores the parameters of the map in a complete session.
  void set_map_parameters(const std::string& yaml) { existing_->set_configuration("map", yaml); }

  /// Opens the session for writing, each time from the beginning. The one returned before must be
  /// closed.
  session::Session open(const report::RunRecord& record);
  /// Moves the written session, with this number of key frames, into place; it must be closed.
  /// Returns false if the existing session reaches farther and is kept.
  bool commit(const report::RunRecord& record, std::size_t key_frames);

 private:
  bool is_mapped_again() const { return exists_ && resume_ == Resume::kExact; }
  void move_into_place();

  const std::filesystem::path folder_;
  const std::filesystem::path staging_folder_;
  const Resume resume_;
  bool exists_ = false;
  std::size_t key_frames_before_ = 0;
  std::map<std::string, std::string> parameters_;  ///< of the existing session
  std::optional<report::RunRecord> record_;        ///< of the existing session
  std::optional<session::Session>
      existing_;  ///< open, so that its lock keeps other programs from writing to it
};

}  // namespace lidar_mapping::tools
