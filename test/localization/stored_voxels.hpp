// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

namespace lidar_mapping::localization::test {

/// The bytes of the voxels whose columns [first, last] along x are these, by their keys.
inline std::map<VoxelKey, std::string> stored_voxels(const registration::GaussianVoxelMap& map,
                                                     int first, int last) {
  std::map<VoxelKey, std::string> bytes;
  for (const registration::VoxelSums& voxel : map.table().slots()) {
    const int column = voxel_index(voxel.key).x();
    if (voxel.key == 0 || column < first || column > last) continue;
    bytes[voxel.key] = std::string(reinterpret_cast<const char*>(&voxel), sizeof(voxel));
  }
  return bytes;
}

}  // namespace lidar_mapping::localization::test
