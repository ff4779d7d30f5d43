// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"

#include "surface.hpp"

namespace lidar_mapping::loop_closing {

/// Where a cloud came to lie.
struct Alignment {
  Pose T_target_source;
  bool converged = false;
  int iterations = 0;
  /// Of T_target_source, from the Hessian and the spread of the last residuals; not floored.
  Covariance6 covariance = Covariance6::Identity();
};

/// Robust point-to-plane registration, coarse to fine: pair distances shrink from 5 to 0.6 m while
/// the number of points grows (doc/loop_closing.md). Converges from 2 m and 5 degrees.
Alignment align_point_to_plane(const std::vector<Eigen::Vector3f>& source,
                               const SurfaceCloud& target, const Pose& T_target_source_guess);

/// The covariance that align_point_to_plane() would state if it had ended at this pose; none where
/// too few points have a partner there.
std::optional<Covariance6> point_to_plane_covariance(const std::vector<Eigen::Vector3f>& source,
                                                     const SurfaceCloud& target,
                                                     const Pose& T_target_source);

}  // namespace lidar_mapping::loop_closing
