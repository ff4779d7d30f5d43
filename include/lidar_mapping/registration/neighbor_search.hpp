// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::registration {

/// In which voxels of a map the partners of a point are looked for.
enum class NeighborSearch {
  kDirect1,  ///< the voxel of the point
  kDirect7,  ///< and the six that share a face with it
  kKdTree    ///< all voxels whose mean is within one voxel edge, as a radius search would give them
};

}  // namespace lidar_mapping::registration
