// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/loop.hpp"

#include "trajectory.hpp"

namespace lidar_mapping::loop_closing {

/// Matches between segments of the trajectory that nothing joins yet. Two streets can look alike,
/// so one match is not believed without a prior; matches that agree over a long way are.
class SegmentConnector {
 public:
  /// `stretch`: the way (m) that no two places look alike over.
  explicit SegmentConnector(double min_path_length) : min_path_length_(min_path_length) {}

  /// Takes in a match; returns all that are to be believed now, this one included, or none.
  std::vector<Loop> add(const Loop& loop, const Trajectory& trajectory);

 private:
  struct KnownMatch {
    Loop loop;
    bool accepted = false;
  };
  double min_path_length_;
  std::vector<KnownMatch> matches_;  // bounded; the oldest is given up
};

}  // namespace lidar_mapping::loop_closing
