// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <sys/types.h>

#include "temporary_folder.hpp"

namespace lidar_mapping::test {

/// Wall time after which something that ought to happen has not: long, as a machine may be busy
/// with other things, and no test waits so long that passes.
constexpr double kPatience = 60.0;  // s

/// A program of this package that runs beside the test and ends with this object.
class NodeProcess {
 public:
  /// Arguments are given as on the command line; `_name:=value` sets a private parameter.
  explicit NodeProcess(const std::string& program, const std::vector<std::string>& arguments = {});
  ~NodeProcess();
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  bool is_running();
  /// Asks it to end (SIGINT) and waits.
  void stop();
  /// Ends it without a chance to tidy up.
  void kill();
  /// Exit status; waits at most `seconds` and is -1 if it has not ended by itself.
  int wait(double seconds = kPatience);
  /// All that it has written to both streams so far.
  std::string output() const;
  /// How often it has written this text so far.
  std::size_t count(const std::string& text) const;
  bool says(const std::string& text) const { return count(text) > 0; }

 private:
  void end(int signal);

  pid_t pid_ = -1;
  int status_ = -1;
  TemporaryFolder folder_;
  std::string output_file_;
};

}  // namespace lidar_mapping::test
