// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// Distances travelled (m) from the first of `count` positions to each; `position_of(i)` gives a
/// vector in m. Nothing is travelled from position i - 1 to i if `is_apart(i)`, as where the next
/// vehicle begins.
template <typename PositionOf, typename IsApart>
std::vector<double> travelled_distances(std::size_t count, const PositionOf& position_of,
                                        const IsApart& is_apart) {
  std::vector<double> distances(count, 0.0);
  for (std::size_t i = 1; i < count; ++i) {
    const double step = is_apart(i) ? 0.0 : (position_of(i) - position_of(i - 1)).norm();
    distances[i] = distances[i - 1] + step;
  }
  return distances;
}

/// The same along a single path.
template <typename PositionOf>
std::vector<double> travelled_distances(std::size_t count, const PositionOf& position_of) {
  return travelled_distances(count, position_of, [](std::size_t) { return false; });
}

/// Distances travelled (m) from the first key frame to each, in the map.
inline std::vector<double> travelled_distances(const KeyFramePoses& poses) {
  return travelled_distances(poses.poses.size(), [&](std::size_t i) -> const Eigen::Vector3d& {
    return poses.poses[i].T_map_base.translation;
  });
}

/// Length (m) of the path through `count` positions; 0 of no positions.
template <typename PositionOf>
double path_length(std::size_t count, const PositionOf& position_of) {
  return count == 0 ? 0.0 : travelled_distances(count, position_of).back();
}

/// Length (m) of the path through key frames in the map; 0 of no key frames.
inline double path_length(const KeyFramePoses& poses) {
  return poses.poses.empty() ? 0.0 : travelled_distances(poses).back();
}

}  // namespace lidar_mapping
