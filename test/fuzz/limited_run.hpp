// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lidar_mapping::test {

/// What became of a command.
struct RunResult {
  int status = 0;      ///< of its exit
  int signal = 0;      ///< that ended it, or 0
  bool hung = false;   ///< it did not end, or took too much processor time
  std::string output;  ///< both streams
};

/// Runs a program of this package with at most `seconds` of processor time, and as much more by the
/// clock as a busy machine may need. The sanitized readers stand in front of the program's
/// libraries.
RunResult run_limited(const std::filesystem::path& program, const std::vector<std::string>& words,
                      const std::filesystem::path& output, unsigned seconds);

}  // namespace lidar_mapping::test
