// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>
#include <filesystem>

namespace lidar_mapping::session {

/// Creates a new folder in `root` with a name by the instant `now` (local time), and sets the link
/// root/latest to it. Two processes never get the same folder.
std::filesystem::path make_run_folder(const std::filesystem::path& root, std::time_t now);

/// A lock for writing in a folder. Only one process at a time can hold it; the system releases it
/// when the process ends for any reason.
class WriteLock {
 public:
  /// Throws FileError if another process holds the lock.
  explicit WriteLock(const std::filesystem::path& folder);
  ~WriteLock();
  WriteLock(const WriteLock&) = delete;
  WriteLock& operator=(const WriteLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace lidar_mapping::session
