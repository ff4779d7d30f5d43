// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <ceres/cost_function.h>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/floor.hpp"

namespace lidar_mapping::pose_graph {

// Whitened residuals with analytic derivatives on the tangent of tangent.hpp; formulas in
// doc/back_end.md. All take the states of one or two nodes. For a new kind of constraint, add one
// more function of this sort: graph and solvers use residuals only as cost functions.

/// A residual with its derivatives, owned.
using CostPtr = std::unique_ptr<ceres::CostFunction>;

/// Converts a covariance of translation (m) and rotation vector (rad) to the information of g2o's
/// error, which consists of the translation and the vector part of the quaternion.
Matrix6d g2o_information(const Covariance6& covariance);

/// Residual of a measured relative pose T_from_to of two nodes; information as from
/// g2o_information(). 6 rows.
CostPtr relative_pose_residual(const Pose& T_from_to, const Matrix6d& information);
/// Residual of a measured pose of one node; information as above. 6 rows.
CostPtr prior_residual(const Pose& T_map_base, const Matrix6d& information);
/// Residual of a measured horizontal antenna position of one node. The antenna is at
/// `p_base_antenna` in base_link and was measured at `p_map_antenna` (m) with `covariance` (m^2) of
/// x and y. 2 rows.
CostPtr antenna_horizontal_residual(const Eigen::Vector3d& p_map_antenna,
                                    const Eigen::Vector3d& p_base_antenna,
                                    const Eigen::Matrix2d& covariance);
/// Residual of a measured altitude of the antenna of one node, with `stddev` in m. 1 row.
CostPtr antenna_altitude_residual(double z_map_antenna, const Eigen::Vector3d& p_base_antenna,
                                  double stddev);
/// Residual of a measured vertical direction of one node: the map's z axis in base_link is the unit
/// vector `up_base`, with `stddev` in rad. 2 rows.
CostPtr tilt_residual(const Eigen::Vector3d& up_base, double stddev);
/// Residual of a measured heading of one node: the angle of base_link's x axis about the map's z
/// axis, with `stddev`, both in rad. 1 row.
CostPtr heading_residual(double yaw, double stddev);
/// Residual of two nodes that stand on one plane. Each floor is in the base_link of its node. The
/// covariance is that of the differences in the two angles (rad) and the height (m). 3 rows.
CostPtr common_floor_residual(const Floor& first, const Floor& second,
                              const Eigen::Matrix3d& covariance);
/// Residual of a measured relative pose of two nodes of a planar graph: x, y (m) and yaw (rad) of
/// the second node in the first, with their information. 3 rows.
CostPtr planar_relative_pose_residual(const Eigen::Vector3d& motion,
                                      const Eigen::Matrix3d& information);

}  // namespace lidar_mapping::pose_graph
