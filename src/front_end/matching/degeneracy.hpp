// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Smallest eigenvalue, as a fraction of the trace, of an observed direction. Measured on simulated
/// drives: the middle of a smooth tunnel has less than 0.0003. A road through fields has 0.0009 (64
/// beams, most of them on the ground) to 0.007, and is tracked well with that.
constexpr double kDegenerateFraction = 0.0006;
/// The same for a map that was built from a single place. There, a ring of the sensor on rough
/// ground makes planes that move with the sensor and seem to constrain it. Measured on simulated
/// drives: in an open field they give up to 0.017 although they contain no information. Streets and
/// a motorway have more than 0.025, rooms seen with few beams have 0.014.
constexpr double kSinglePlaceFraction = 0.018;

/// Directions of translation (unit vectors, axes of the sensor) that the points hardly observe: the
/// eigenvectors of the Hessian's translation block whose eigenvalue is less than `fraction` of its
/// trace.
std::vector<Eigen::Vector3d> degenerate_directions(const Matrix6d& pose_hessian,
                                                   double fraction = kDegenerateFraction);

/// The projection of translations onto the complement of `directions`.
Eigen::Matrix3d projection_orthogonal_to(const std::vector<Eigen::Vector3d>& directions);

}  // namespace lidar_mapping::front_end
