// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <ceres/cost_function.h>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/floor.hpp"

namespace lidar_mapping::pose_graph {

// Whitened residuals with analytic derivatives on the tangent of tangent.hpp; formulas in
// doc/back_end.md. All take blocks of one or two nodes. A constraint of a new kind is a further
// function of this sort: the graph and its solvers know residuals only as cost functions.

using CostPtr = std::unique_ptr<ceres::CostFunction>;

/// Information of g2o's error (translation, vector part of the quaternion) from a covariance of
/// (translation, rotation vector).
Matrix6d g2o_information(const Covariance6& covariance);

/// Two nodes: T_from_to was measured; information as in g2o_information().
CostPtr relative_pose_residual(const Pose& T_from_to, const Matrix6d& information);
/// One node: its pose was measured.
CostPtr prior_residual(const Pose& T_map_base, const Matrix6d& information);
/// One node: the antenna at `p_base_antenna` was measured at `p_map_antenna`, horizontally.
CostPtr antenna_horizontal_residual(const Eigen::Vector3d& p_map_antenna,
                                    const Eigen::Vector3d& p_base_antenna,
                                    const Eigen::Matrix2d& covariance);
/// The same for the altitude alone.
CostPtr antenna_altitude_residual(double z_map_antenna, const Eigen::Vector3d& p_base_antenna,
                                  double stddev);
/// One node: the map's z axis was seen along the unit vector `up_base`, with stddev in rad.
CostPtr tilt_residual(const Eigen::Vector3d& up_base, double stddev);
/// One node: the angle of base_link's x axis about the map's z axis, rad.
CostPtr heading_residual(double yaw, double stddev);
/// Two nodes: both stand on one plane, seen in each base_link. The covariance is that of the two
/// angles and the height of one plane seen from the other's place.
CostPtr common_floor_residual(const Floor& first, const Floor& second,
                              const Eigen::Matrix3d& covariance);
/// Two nodes of a planar graph: x, y, yaw of the second in the first.
CostPtr planar_relative_pose_residual(const Eigen::Vector3d& motion,
                                      const Eigen::Matrix3d& information);

}  // namespace lidar_mapping::pose_graph
