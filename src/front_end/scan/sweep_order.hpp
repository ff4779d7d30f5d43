// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// True if the points are in the order in which a spinning sensor measured them, firing by firing
/// around the z axis, and not ring by ring or in the order of a filter.
bool in_sweep_order(const PointCloud& cloud);

}  // namespace lidar_mapping::front_end
