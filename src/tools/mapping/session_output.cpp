// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/session_output.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::tools {

namespace {

namespace fs = std::filesystem;
using session::Session;

constexpr const char* kStagingFolder = ".resumed";

/// Whether the folder has more than the files that a process leaves which was killed at its start.
bool has_results(const fs::path& folder) {
  const fs::directory_iterator entries(folder);
  return std::any_of(begin(entries), end(entries), [](const auto& entry) {
    const fs::path name = entry.path().filename();
    return name != "lock" && name != "run.json" && name != ".run.json.part";
  });
}

void check_new(const fs::path& folder) {
  if (!fs::exists(folder)) return;
  if (!fs::is_directory(folder)) {
    throw FileError(folder.string() + " is no folder; name a new one");
  }
  if (!has_results(folder)) return;
  throw FileError(folder.string() +
                  " is not empty; name a new folder, or give --resume to continue a session that "
                  "was interrupted");
}

void refuse_edited(const Session& session) {
  const auto loops = session.loops();
  const bool is_edited = std::any_of(loops.begin(), loops.end(), [](const Loop& loop) {
    return loop.decision != LoopDecision::kAuto || loop.source == LoopSource::kManual;
  });
  if (!is_edited) return;
  throw InputError(
      "in " + session.directory().string() +
      " a user has decided about loops; the decisions would be lost if it were mapped again; "
      "--quick-resume continues it as it is");
}

/// Removes the logs of the database of a closed session; beside another database they would be read
/// as its own.
void remove_logs(const fs::path& folder) {
  for (const char* log : {"session.db-wal", "session.db-shm"}) fs::remove(folder / log);
}

/// Removes unfinished files, which write_atomically() leaves when the process is killed.
void remove_unfinished(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (name.front() == '.' && entry.path().extension() == ".part") files.push_back(entry.path());
  }
  for (const fs::path& file : files) fs::remove(file);
}

}  // namespace

SessionOutput::SessionOutput(fs::path folder, Resume resume)
    : folder_(std::move(folder)), staging_folder_(folder_ / kStagingFolder), resume_(resume) {
  if (resume_ == Resume::kNo || !fs::exists(folder_ / "session.db")) {
    check_new(folder_);
    return;
  }
  exists_ = true;
  existing_ = Session::open(folder_, Session::Access::kWrite);
  key_frames_before_ = existing_->key_frame_count();
  parameters_ = existing_->configurations();
  record_ = report::read_run_record(folder_);
  if (resume_ == Resume::kExact) refuse_edited(*existing_);
}

SessionOutput::~SessionOutput() {
  if (!is_mapped_again()) return;
  std::error_code ignored;
  fs::remove_all(staging_folder_, ignored);
}

void SessionOutput::check(const report::RunRecord& record,
                          const std::map<std::string, std::string>& parameters) const {
  if (!exists_) return;
  const std::string remedy = "; name a new folder for this recording";
  if (!record_ && resume_ == Resume::kExact && key_frames_before_ > 0) {
    throw InputError("nothing in " + folder_.string() +
                     " records from which recording its session was made" + remedy +
                     ", or give --quick-resume if you know that it is this one");
  }
  std::string difference;
  if (record_) difference = report::recording_difference(*record_, record);
  if (!difference.empty()) {
    throw InputError("the session in " + folder_.string() +
                     " is of another recording: " + difference + remedy);
  }
  std::map<std::string, std::string> of_stages = parameters;
  of_stages.erase("map");
  difference = report::parameter_difference(parameters_, of_stages);
  if (difference.empty()) return;
  throw InputError("the session in " + folder_.string() + " was made with other parameters: " +
                   difference + "; give the same, or name a new folder");
}

Session SessionOutput::open(const report::RunRecord& record) {
  if (is_mapped_again()) {
    fs::remove_all(staging_folder_);
    return Session::create_in(staging_folder_);
  }
  existing_.reset();
  if (exists_ || fs::exists(folder_ / "session.db")) {  // or created by this run before a restart
    return Session::open(folder_, Session::Access::kWrite);
  }
  report::write_run_record(folder_, record);
  return Session::create_in(folder_);
}

bool SessionOutput::commit(const report::RunRecord& record, std::size_t key_frames) {
  if (is_mapped_again()) {
    if (key_frames < key_frames_before_) return false;
    move_into_place();
  }
  report::write_run_record(folder_, record);
  return true;
}

/// Moves the clouds first: those of the existing session have the same bytes, so that it stays
/// valid until its database is replaced.
void SessionOutput::move_into_place() {
  existing_.reset();
  fs::create_directories(folder_ / "key_frames");
  for (const char* part : {"key_frames", "trajectory"}) {
    if (!fs::exists(staging_folder_ / part)) continue;
    fs::create_directories(folder_ / part);
    for (const auto& entry : fs::directory_iterator(staging_folder_ / part)) {
      fs::rename(entry.path(), folder_ / part / entry.path().filename());
    }
    remove_unfinished(folder_ / part);
  }
  remove_unfinished(folder_);
  remove_logs(folder_);
  for (const auto& entry : fs::directory_iterator(staging_folder_)) {
    if (!entry.is_regular_file() || entry.path().filename() == "lock") continue;
    fs::rename(entry.path(), folder_ / entry.path().filename());
  }
}

}  // namespace lidar_mapping::tools
