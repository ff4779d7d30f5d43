// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

#include "scenes.hpp"

namespace lidar_mapping::registration {

inline void insert(const PointCloud& cloud, GaussianVoxelMap& map) {
  for (const Point& p : cloud.points) map.insert(&p.x, &p.y, &p.z, 1);
}

/// A map of street_corner() with voxels of 1 m.
inline GaussianVoxelMap corner_map() {
  GaussianVoxelMap map(1.0, 1 << 14);
  insert(test::street_corner(1, 30000, 0.02), map);
  return map;
}

}  // namespace lidar_mapping::registration
