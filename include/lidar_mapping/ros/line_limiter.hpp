// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

namespace lidar_mapping::ros_border {

/// Thins a log in which one line replaces the one before, as a count that grows: the first is said
/// at once, then at most one in 10 s, always the newest. One thread calls it.
class LineLimiter {
 public:
  /// What to say now, if anything; `now` is any clock's time in s.
  std::optional<std::string> add(std::string line, double now);
  /// The newest line if it has not been said: when no other follows.
  std::optional<std::string> rest();

 private:
  std::optional<double> said_at_;
  std::optional<std::string> unsaid_;
};

}  // namespace lidar_mapping::ros_border
