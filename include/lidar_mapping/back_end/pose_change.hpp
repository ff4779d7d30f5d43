// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::back_end {

/// How far the same key frames lie from each other in two states of a map.
struct PoseChange {
  std::size_t key_frames = 0;  ///< that are in both
  double mean = 0.0;           ///< m
  double largest = 0.0;        ///< m
  KeyFrameIndex farthest = 0;  ///< the key frame that moved by `largest`
  Stamp stamp = 0;             ///< of that key frame
};

/// Joined by index; both ordered by it, as KeyFramePoses are.
PoseChange change_between(const KeyFramePoses& before, const KeyFramePoses& after);

}  // namespace lidar_mapping::back_end
