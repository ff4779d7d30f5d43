#pragma once

#include <vector>

#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// Directions of translation (unit, axes of the sensor) along which the points say almost nothing:
/// the eigenvectors of the Hessian's translation block with a small share of its trace.
std::vector<Eigen::Vector3d> degenerate_directions(const Matrix6d& pose_hessian);

/// The match without what the points said about translation along `directions`: there the pose and
/// the twist follow `instead` (Zhang, Kaess, Singh 2016). `matched_with` is the prior of the match.
registration::NdtMatch without_directions(const registration::NdtMatch& match,
                                          const registration::MotionBelief& matched_with,
                                          const registration::MotionBelief& instead,
                                          const std::vector<Eigen::Vector3d>& directions);

}  // namespace lidar_mapping::front_end
