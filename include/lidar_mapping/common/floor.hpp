// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// The floor below the vehicle: normal . p + offset = 0 for p in base_link, normal upward.
struct Floor {
  Stamp stamp = 0;                                    ///< of the scan in which it was searched
  bool found = false;                                 ///< if false, only the stamp has a meaning
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit length, in base_link
  double offset = 0.0;                                ///< height of base_link above the floor, m
  /// Of rotation about x, rotation about y (rad) and height (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  int inliers = 0;  ///< number of points on the plane
};

}  // namespace lidar_mapping
