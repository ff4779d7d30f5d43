// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "lidar_mapping/session/session.hpp"

#include "run_record.hpp"

namespace lidar_mapping::tools {

/// What is done about a session that lies in the output folder already.
enum class Resume {
  kNo,     ///< it is left alone: the folder must be new
  kExact,  ///< the recording is mapped from its beginning: the same bytes as in an undisturbed run
  kQuick   ///< its end is gone on from
};

/// The folder that a recording is mapped into. With Resume::kExact the new session grows aside, in
/// a hidden folder, and takes the place of the old one when it reaches at least as far: a run that
/// is broken off, too, takes nothing away.
class SessionOutput {
 public:
  /// Throws FileError if the folder may not be written to, InputError for a session that a person
  /// has edited and that therefore cannot be made again.
  SessionOutput(std::filesystem::path folder, Resume resume);
  ~SessionOutput();
  SessionOutput(const SessionOutput&) = delete;
  SessionOutput& operator=(const SessionOutput&) = delete;

  /// Throws InputError if there is a session that was made from another recording or with other
  /// parameters (texts of the stages; those of the map may differ).
  void check(const report::RunRecord& record,
             const std::map<std::string, std::string>& parameters) const;
  /// The session that is there has the whole recording.
  bool is_complete() const { return record_ && record_->is_complete; }
  /// Of the session that is there.
  std::size_t key_frames_before() const { return key_frames_before_; }
  bool is_resumed() const { return is_there_; }

  /// Of a session that is complete: parameters of its map.
  void set_map_parameters(const std::string& yaml) { old_->set_configuration("map", yaml); }

  /// The session to be written, each time as if it were the first. Nobody may hold the one before.
  session::Session open(const report::RunRecord& record);
  /// Puts what was written, so many key frames, in its place when nobody writes to it any more.
  /// False if the old session reaches farther and stays.
  bool commit(const report::RunRecord& record, std::size_t key_frames);

 private:
  bool is_made_again() const { return is_there_ && resume_ == Resume::kExact; }
  void move_into_place();

  const std::filesystem::path folder_;
  const std::filesystem::path aside_;
  const Resume resume_;
  bool is_there_ = false;
  std::size_t key_frames_before_ = 0;
  std::map<std::string, std::string> parameters_;  ///< of the session that is there
  std::optional<report::RunRecord> record_;        ///< of the session that is there
  std::optional<session::Session> old_;            ///< keeps others from writing to it
};

}  // namespace lidar_mapping::tools
