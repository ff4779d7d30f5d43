// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"

#include "matching/surface.hpp"

namespace lidar_mapping::loop_closing {

/// The result of a registration.
struct Alignment {
  Pose T_target_source;
  bool converged = false;
  int iterations = 0;
  /// Covariance of T_target_source from the Hessian and the variance of the last residuals, without
  /// a lower bound. The noise of normals passes for information: on an even field whose points
  /// scatter it is much too small in the directions that nothing determines. No loop comes of such
  /// a field, because nothing stands above its ground (MatchFigures::tested_points).
  Covariance6 covariance = Covariance6::Identity();
};

/// Robust point-to-plane registration from coarse to fine: the largest pair distance decreases from
/// 5 to 0.6 m while the number of points grows (doc/loop_closing.md). It is made for errors of the
/// guess up to 2 m and 5 degrees, and mostly finds the pose from there. It may also end at a wrong
/// one, with `converged` true: the figures of the match have to tell (measure_match()).
Alignment align_point_to_plane(const std::vector<Eigen::Vector3f>& source,
                               const SurfaceCloud& target, const Pose& T_target_source_guess);

/// The covariance that align_point_to_plane() would give if it had ended at this pose. Empty if too
/// few points have a partner there.
std::optional<Covariance6> point_to_plane_covariance(const std::vector<Eigen::Vector3f>& source,
                                                     const SurfaceCloud& target,
                                                     const Pose& T_target_source);

}  // namespace lidar_mapping::loop_closing
