// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// All of these points, measured `seconds` after the reference time.
inline SampledPoints sampled(const std::vector<Eigen::Vector3f>& points, float seconds = 0.0F) {
  SampledPoints result;
  for (const Eigen::Vector3f& p : points) result.push_back(p, seconds);
  return result;
}

}  // namespace lidar_mapping::front_end
