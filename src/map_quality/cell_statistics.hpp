// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "lidar_mapping/common/plane_fit.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::map_quality {

/// A plane fitted to the points of a cell.
struct Plane {
  Eigen::Vector3d normal;
  Eigen::Vector3d centre;
  double thickness = 0.0;  ///< Standard deviation along the normal, m.
  double extent = 0.0;     ///< Second largest standard deviation, m.
};

/// Second largest standard deviation of the points of a plane, in edges of the cell; a square that
/// fills the cell has 0.29. Chosen: below half of that the points are closer to a line than to a
/// surface.
constexpr double kMinExtent = 0.15;

inline Plane plane_of(const PointMoments& moments) {
  const PlaneFit fit(moments);
  return {fit.normal, fit.mean, std::sqrt(fit.variances[0]), std::sqrt(fit.variances[1])};
}

/// True up to a slope of 26 degrees (0.9 is its cosine): ramps, roads and floors.
inline bool is_ground(const Plane& plane) { return std::abs(plane.normal.z()) > 0.9; }
/// True up to 14 degrees from the vertical (0.25 is their sine).
inline bool is_wall(const Plane& plane) { return std::abs(plane.normal.z()) < 0.25; }

/// Key of the cell of edge `size` (m) in which a point lies.
inline VoxelKey cell_key(const Eigen::Vector3d& point, double size) {
  return voxel_key(voxel_index(point / size));
}

}  // namespace lidar_mapping::map_quality
