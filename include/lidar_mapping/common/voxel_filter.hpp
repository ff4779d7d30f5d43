// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping {

/// One point per occupied voxel of edge `resolution` (m): the centroid with the mean intensity
/// (and the mean time where there are times). Voxels come in the order of their first point, so the
/// result does not depend on hashing. Indices have 64 bits for each axis, so the extent is not
/// limited. Points that are not finite are left out. A resolution of 0 or less returns the cloud as
/// it is.
PointCloud voxel_filtered(const PointCloud& cloud, double resolution);

}  // namespace lidar_mapping
