// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/loop.hpp"

namespace lidar_mapping::back_end {

/// Standard deviations (m, rad) that the motion T_previous_current has on top of registration's
/// covariance: a least error and drift that grows with the distance. None with
/// use_const_inf_matrix.
Vector6d drift_stddev(const Pose& T_previous_current, const BackEndConfig& config);

/// Covariance of the motion T_previous_current but for drift: that of registration, more in the
/// first metres of a segment (`way` is what has been driven of it, m), and next to no knowledge
/// along degenerate directions (unit vectors in the current base_link). Or constant, with
/// use_const_inf_matrix.
Covariance6 step_covariance(const Covariance6& registration_covariance,
                            const Pose& T_previous_current, double distance_in_segment,
                            const std::vector<Eigen::Vector3d>& degenerate_directions,
                            const BackEndConfig& config);

/// Covariance of a loop from registration with its least error; or by its fitness, saturating as
/// in hdl_graph_slam; or constant.
Covariance6 loop_covariance(const Loop& loop, const BackEndConfig& config);

/// By how much a floor differs from the plane of others, beyond its own covariance; rotation about
/// x and y (rad) and height (m).
Eigen::Matrix3d floor_covariance(const BackEndConfig& config);
/// The same for two floors with their own covariances.
Eigen::Matrix3d neighbours_covariance(const Floor& first, const Floor& second,
                                      const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
