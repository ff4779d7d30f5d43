// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

namespace lidar_mapping::ros_border {

/// Limits the rate of log lines of which each replaces the one before, such as a growing count: the
/// first is printed at once, then at most one in 10 s, always the newest. One thread calls it.
class LineLimiter {
 public:
  /// Returns the line if it is to be printed now; `now` is any clock's time in s.
  std::optional<std::string> add(std::string line, double now);
  /// Returns the newest line if it has not been printed: for the end, when no other follows.
  std::optional<std::string> rest();

 private:
  std::optional<double> printed_at_;
  std::optional<std::string> pending_;
};

}  // namespace lidar_mapping::ros_border
