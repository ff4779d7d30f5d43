// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::back_end {

/// Distances between the positions of the same key frames in two states of a map.
struct PoseChange {
  std::size_t key_frames = 0;  ///< number of key frames that are in both states
  double mean = 0.0;           ///< mean distance, m
  double largest = 0.0;        ///< largest distance, m
  KeyFrameIndex farthest = 0;  ///< key frame with the largest distance
  Stamp stamp = 0;             ///< stamp of that key frame
};

/// Compares two states of a map. The key frames are paired by index; both inputs must be ordered by
/// index, as KeyFramePoses are.
PoseChange change_between(const KeyFramePoses& before, const KeyFramePoses& after);

}  // namespace lidar_mapping::back_end
