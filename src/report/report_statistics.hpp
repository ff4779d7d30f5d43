// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::report {

/// Distance travelled from the first pose to each, m.
inline std::vector<double> distances_of(const KeyFramePoses& poses) {
  std::vector<double> distances(poses.poses.size(), 0.0);
  for (std::size_t i = 1; i < distances.size(); ++i) {
    const auto position = [&](std::size_t k) { return poses.poses[k].T_map_base.translation; };
    distances[i] = distances[i - 1] + (position(i) - position(i - 1)).norm();
  }
  return distances;
}

}  // namespace lidar_mapping::report
