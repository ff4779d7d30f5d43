// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

#include "pcl_clouds.hpp"

namespace lidar_mapping::registration {

/// The voxels of a whole cloud, large enough a table for any cloud, with the origin in its middle.
GaussianVoxelMap voxel_target(const PclCloud& cloud, double resolution, const PlaneModel& model);

}  // namespace lidar_mapping::registration
