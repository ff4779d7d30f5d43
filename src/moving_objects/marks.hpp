// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::moving_objects {

/// Indices of points in ascending order.
using Marks = std::vector<std::uint32_t>;

/// The points of a cloud with these indices.
PointCloudPtr marked_points(const PointCloud& cloud, const Marks& marks);
/// All other points of a cloud.
PointCloudPtr unmarked_points(const PointCloud& cloud, const Marks& marks);

}  // namespace lidar_mapping::moving_objects
