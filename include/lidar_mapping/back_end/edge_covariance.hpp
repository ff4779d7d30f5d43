#pragma once

#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/loop.hpp"

namespace lidar_mapping::back_end {

/// Covariance of the motion T_previous_current from registration, made honest: a least error, drift
/// that grows with the distance, more of both in the first metres of a segment (`way` is what has
/// been driven of it, m), and next to no knowledge along degenerate directions (unit vectors in the
/// current base_link). Or constant, with use_const_inf_matrix.
Covariance6 odometry_covariance(const Covariance6& of_registration, const Pose& T_previous_current,
                                double way,
                                const std::vector<Eigen::Vector3d>& degenerate_directions,
                                const BackEndConfig& config);

/// Covariance of a loop from registration with its least error; or by its fitness, saturating as
/// in hdl_graph_slam; or constant.
Covariance6 loop_covariance(const Loop& loop, const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
