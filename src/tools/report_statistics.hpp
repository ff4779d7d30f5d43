#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::tools {

constexpr double kDegrees = 180.0 / M_PI;

/// Distance travelled from the first pose to each, m.
inline std::vector<double> distances_of(const KeyFramePoses& poses) {
  std::vector<double> distances(poses.poses.size(), 0.0);
  for (std::size_t i = 1; i < distances.size(); ++i) {
    const auto position = [&](std::size_t k) { return poses.poses[k].T_map_base.translation; };
    distances[i] = distances[i - 1] + (position(i) - position(i - 1)).norm();
  }
  return distances;
}

/// The value below which a share of all lies; 0 of none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace lidar_mapping::tools
