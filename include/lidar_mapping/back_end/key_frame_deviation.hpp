// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"

namespace lidar_mapping::back_end {

/// Standard deviations of a pose, each the root of the sum over three axes; infinite where nothing
/// ties it.
struct PoseDeviation {
  double position = std::numeric_limits<double>::infinity();  ///< m
  double angle = std::numeric_limits<double>::infinity();     ///< rad
};

/// How well the graph knows a key frame, by all that it believes: odometry with its doubtful steps,
/// loops, GNSS, floors.
struct KeyFrameDeviation {
  KeyFrameIndex index = 0;
  int part = 0;                 ///< of the map, as in BackEnd::parts()
  bool doubtful = false;        ///< a step of the motion to it may be wrong
  PoseDeviation from_first;     ///< if the first key frame were known exactly
  PoseDeviation from_previous;  ///< of the motion from the key frame before; 0 for the first
};

/// For each key frame, in their order; from one factorisation (SelectedInverse).
std::vector<KeyFrameDeviation> key_frame_deviations(const OptimizationProblem& problem);

}  // namespace lidar_mapping::back_end
