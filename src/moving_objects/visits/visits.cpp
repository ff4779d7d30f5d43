// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/visits.hpp"

#include <algorithm>
#include <numeric>

namespace lidar_mapping::moving_objects {

Visits::Visits(const std::vector<KeyFramePose>& poses) : numbers_(poses.size()) {
  std::vector<std::size_t> by_time(poses.size());
  std::iota(by_time.begin(), by_time.end(), std::size_t{0});
  std::stable_sort(by_time.begin(), by_time.end(),
                   [&](std::size_t a, std::size_t b) { return poses[a].stamp < poses[b].stamp; });
  for (const std::size_t i : by_time) {
    const Stamp stamp = poses[i].stamp;
    if (visits_.empty() || to_seconds(stamp - visits_.back().end) > kPause) {
      visits_.push_back({stamp, stamp});
    }
    visits_.back().end = stamp;
    numbers_[i] = visits_.size() - 1;
  }
}

}  // namespace lidar_mapping::moving_objects
