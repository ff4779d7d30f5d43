// SPDX-License-Identifier: BSD-3-Clause
#include "decision/elevation_range.hpp"

#include <algorithm>

namespace lidar_mapping::loop_closing {

namespace {

float slope_of(const Eigen::Vector3f& ray) { return ray.z() / ray.head<2>().norm(); }

}  // namespace

void ElevationRange::add(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& lidar) {
  for (const Eigen::Vector3f& p : points) {
    const float slope = slope_of(p - lidar);
    lowest_ = std::min(lowest_, slope);
    highest_ = std::max(highest_, slope);
  }
}

bool ElevationRange::contains(const Eigen::Vector3f& point, const Eigen::Vector3f& lidar) const {
  const float slope = slope_of(point - lidar);
  return slope >= lowest_ && slope <= highest_;
}

}  // namespace lidar_mapping::loop_closing
