// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

namespace lidar_mapping::ros_border {

/// Counts by header.seq the recorded scans that were never received. `rosbag play` keeps the
/// numbers of the recording, and loses the messages that it plays before subscribers are connected.
/// Scans are only counted where the numbers show them: not with a source that does not number its
/// messages, and not before a first scan without a small number.
class ScanNumbers {
 public:
  /// Adds the number (header.seq) of a scan, in the order of arrival.
  void add(std::uint32_t number);

  /// Scans before the first received one; 0 if the recording does not begin with a small number
  /// because the driver had been running before.
  std::size_t before_first() const { return before_first_; }
  /// Scans missing between the received ones. A thinned recording (for example every second scan)
  /// has no missing scans: the smallest step counts as one.
  std::size_t between() const;
  /// All scans that were never received.
  std::size_t missing() const { return before_first() + between(); }

 private:
  std::optional<std::uint32_t> first_;
  std::uint32_t newest_ = 0;
  std::uint32_t step_ = 0;                  ///< smallest difference so far; 0: none yet
  std::size_t received_ = 0;                ///< since `first_`
  std::size_t before_first_ = 0;            ///< missing before the first received scan
  std::size_t missing_before_restart_ = 0;  ///< missing before the numbers restarted
};

}  // namespace lidar_mapping::ros_border
