#pragma once

#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Directions of translation (unit, axes of the sensor) along which the points say almost nothing:
/// the eigenvectors of the Hessian's translation block with a small share of its trace.
std::vector<Eigen::Vector3d> degenerate_directions(const Matrix6d& pose_hessian);

/// The projection of translations onto what is left beside `directions`.
Eigen::Matrix3d projection_beside(const std::vector<Eigen::Vector3d>& directions);

}  // namespace lidar_mapping::front_end
