// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/loop.hpp"

#include "trajectory.hpp"

namespace lidar_mapping::loop_closing {

/// Collects matches between segments of the trajectory that are not connected yet. Two streets may
/// look alike, so that a single match without a prior is not accepted. Matches that agree over a
/// long path are accepted.
class SegmentConnector {
 public:
  /// `min_path_length`: path length (m) over which no two locations look alike.
  explicit SegmentConnector(double min_path_length) : min_path_length_(min_path_length) {}

  /// Adds a match. Returns all matches that are accepted now, including this one, or none.
  std::vector<Loop> add(const Loop& loop, const Trajectory& trajectory);

 private:
  struct KnownMatch {
    Loop loop;
    bool accepted = false;
  };
  double min_path_length_;
  std::vector<KnownMatch> matches_;  // limited; the oldest is dropped
};

}  // namespace lidar_mapping::loop_closing
