// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// For each point (in base_link, m): true if it is more than 0.6 m above the lowest point within
/// about 3.75 m, so that slopes also count as ground.
std::vector<bool> above_ground(const std::vector<Eigen::Vector3f>& points);

}  // namespace lidar_mapping::loop_closing
