// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"

namespace lidar_mapping::back_end {

/// Standard deviations of a pose, each the root of the sum of the variances of three axes. Infinite
/// if no constraint determines the pose.
struct PoseDeviation {
  double position = std::numeric_limits<double>::infinity();  ///< m
  double angle = std::numeric_limits<double>::infinity();     ///< rad
};

/// The uncertainty of one key frame in the graph, by all constraints that the graph uses: odometry
/// with its doubtful steps, loops, GNSS and floors.
struct KeyFrameDeviation {
  KeyFrameIndex index = 0;      ///< index of the key frame
  int part = 0;                 ///< connected part of the map, as in BackEnd::parts()
  bool doubtful = false;        ///< a step of the motion to this key frame may be wrong
  PoseDeviation from_first;     ///< relative to the first key frame
  PoseDeviation from_previous;  ///< relative to the previous key frame; 0 for the first one
};

/// The uncertainty of each key frame, in the order of the key frames. All values come from one
/// factorisation (SelectedInverse).
std::vector<KeyFrameDeviation> key_frame_deviations(const OptimizationProblem& problem);

}  // namespace lidar_mapping::back_end
