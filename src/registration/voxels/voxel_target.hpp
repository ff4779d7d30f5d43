// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

#include "pcl_methods/pcl_clouds.hpp"

namespace lidar_mapping::registration {

/// The voxels of a cloud, in a table that is large enough for all of its points, with the origin in
/// the middle of the cloud.
GaussianVoxelMap voxel_target(const PclCloud& cloud, double resolution, const PlaneModel& model);

}  // namespace lidar_mapping::registration
