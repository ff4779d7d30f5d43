// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>
#include <filesystem>

namespace lidar_mapping::session {

/// Makes a folder that did not exist, named by the instant (local time), and points the link
/// root/latest to it. Two processes never get the same one.
std::filesystem::path make_run_folder(const std::filesystem::path& root, std::time_t now);

/// The right to write in a folder; held by one process at a time and given back by the system when
/// the process ends, however it ends.
class WriteLock {
 public:
  /// Throws FileError if another process has it.
  explicit WriteLock(const std::filesystem::path& folder);
  ~WriteLock();
  WriteLock(const WriteLock&) = delete;
  WriteLock& operator=(const WriteLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace lidar_mapping::session
