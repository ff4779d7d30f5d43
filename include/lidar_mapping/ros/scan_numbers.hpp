// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

namespace lidar_mapping::ros_border {

/// Counts by header.seq the scans that a recording has and nobody got. `rosbag play` gives messages
/// the numbers that they were recorded with, and loses those that it plays before subscribers are
/// connected. What cannot be known is not counted: a source that numbers nothing, and the scans
/// before the first where that has no small number.
class ScanNumbers {
 public:
  /// Takes the number (header.seq) of a scan, in the order of arrival.
  void take(std::uint32_t number);

  /// Scans before the first one that came; none where the recording does not begin with a small
  /// number, as it does not if the driver had been running before.
  std::size_t before_first() const { return before_first_; }
  /// Scans missing between those that came. A recording that was thinned (every second scan, say)
  /// misses none: the smallest step counts as one.
  std::size_t between() const;
  /// All scans that nobody got.
  std::size_t missing() const { return before_first() + between(); }

 private:
  std::optional<std::uint32_t> first_;
  std::uint32_t newest_ = 0;
  std::uint32_t step_ = 0;        ///< the smallest so far; 0: none yet
  std::size_t received_ = 0;      ///< since `first_`
  std::size_t before_first_ = 0;  ///< of the first that ever came
  std::size_t earlier_ = 0;       ///< missing before the numbers began anew
};

}  // namespace lidar_mapping::ros_border
