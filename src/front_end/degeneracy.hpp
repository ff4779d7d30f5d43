// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// A share of the trace: the middle of a smooth tunnel has less than 0.0003. A road through fields
/// has 0.0009 (64 beams, most of them on the ground) to 0.007, and is followed well with that.
constexpr double kDegenerateFraction = 0.0006;
/// The same in a map that was made from one place. There a ring of the sensor on rough ground makes
/// planes that go with the sensor and hold it: in an open field they give up to 0.017, though they
/// know nothing; streets and a motorway have more than 0.025, rooms seen with few beams 0.014.
constexpr double kSinglePlaceFraction = 0.018;

/// Directions of translation (unit, axes of the sensor) along which the points say almost nothing:
/// the eigenvectors of the Hessian's translation block with less than `share` of its trace.
std::vector<Eigen::Vector3d> degenerate_directions(const Matrix6d& pose_hessian,
                                                   double fraction = kDegenerateFraction);

/// The projection of translations onto what is left beside `directions`.
Eigen::Matrix3d projection_orthogonal_to(const std::vector<Eigen::Vector3d>& directions);

}  // namespace lidar_mapping::front_end
