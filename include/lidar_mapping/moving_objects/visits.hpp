// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::moving_objects {

/// All key frames between two pauses of more than ten minutes: what they contradict each other in
/// has moved, what two visits contradict each other in has changed. Vehicles that map at the same
/// time make one visit together.
struct Visit {
  Stamp begin = 0;  ///< stamp of its first key frame
  Stamp end = 0;    ///< stamp of its last key frame
};

/// The visits of a map in their order in time, and which of them each key frame belongs to.
class Visits {
 public:
  /// The pause after which another visit begins, s. Chosen: a traffic light, a queue or a delivery
  /// is shorter, and whoever comes back for another drive is away for longer.
  static constexpr double kPause = 600.0;

  /// The visits of these key frames, which may be in any order.
  explicit Visits(const std::vector<KeyFramePose>& poses);

  /// All visits, in their order in time.
  const std::vector<Visit>& visits() const { return visits_; }
  /// Number of the visit of the i-th pose.
  std::size_t visit_of(std::size_t i) const { return numbers_[i]; }

 private:
  std::vector<Visit> visits_;
  std::vector<std::size_t> numbers_;
};

}  // namespace lidar_mapping::moving_objects
