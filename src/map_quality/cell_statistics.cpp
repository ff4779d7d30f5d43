// SPDX-License-Identifier: BSD-3-Clause
#include "cell_statistics.hpp"

#include <cmath>

namespace lidar_mapping::map_quality {

Plane plane_of(const PointMoments& moments) {
  const PlaneFit fit(moments);
  return {fit.normal, fit.mean, std::sqrt(fit.variances[0]), std::sqrt(fit.variances[1])};
}

VoxelKey cell_key(const Eigen::Vector3d& point, double size) {
  return voxel_key(voxel_index(point / size));
}

}  // namespace lidar_mapping::map_quality
