// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/loop.hpp"

namespace lidar_mapping::back_end {

/// Standard deviations (m, rad) that are added to the registration's covariance of the motion
/// T_previous_current: a lower bound, and drift that grows with the distance. Zero with
/// use_const_inf_matrix.
Vector6d drift_stddev(const Pose& T_previous_current, const BackEndConfig& config);

/// Covariance of the motion T_previous_current without drift. It is the registration's covariance,
/// larger in the first metres of a segment (`distance_in_segment` is the distance travelled in it,
/// m), and very large along degenerate directions (unit vectors in the current base_link). With
/// use_const_inf_matrix it is constant.
Covariance6 step_covariance(const Covariance6& registration_covariance,
                            const Pose& T_previous_current, double distance_in_segment,
                            const std::vector<Eigen::Vector3d>& degenerate_directions,
                            const BackEndConfig& config);

/// Covariance of a loop: by the registration with a lower bound, by the fitness as in
/// hdl_graph_slam, or constant.
Covariance6 loop_covariance(const Loop& loop, const BackEndConfig& config);

/// Covariance of the difference between a floor and the plane of others, without its own
/// covariance: rotation about x and y (rad) and height (m).
Eigen::Matrix3d floor_covariance(const BackEndConfig& config);
/// The same for two floors, with their own covariances.
Eigen::Matrix3d neighbours_covariance(const Floor& first, const Floor& second,
                                      const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
