// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <ceres/version.h>

#include "lidar_mapping/common/pose.hpp"

// Ceres 2.1 renamed the local parameterization to manifold; older versions know only the former.
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
#define LIDAR_MAPPING_CERES_HAS_MANIFOLD 1
#include <ceres/manifold.h>
#else
#define LIDAR_MAPPING_CERES_HAS_MANIFOLD 0
#include <ceres/local_parameterization.h>
#endif
#include <ceres/problem.h>

namespace lidar_mapping::pose_graph {

/// The state of a node as Ceres sees it: x y z qx qy qz qw, or x y yaw in a planar graph.
using StateBlock = std::array<double, 7>;
constexpr int kPoseBlockSize = 7;
constexpr int kPlanarBlockSize = 3;

StateBlock to_block(const Pose& pose);
Pose to_pose(const double* block);
StateBlock to_planar_block(const Pose& pose);
Pose to_planar_pose(const double* block);

/// T * (dt, (sqrt(1 - v^2), v)) with d = (dt, v): the update of all 3D states; v is half a rotation
/// vector for small angles, as in g2o (doc/back_end.md).
StateBlock retract(const double* block, const double* d);

/// The update for Ceres. Residuals write their derivatives with respect to d into the first six
/// columns of a seven-column Jacobian and zero into the last; the derivative of the update is
/// therefore declared as the identity over a row of zeros, and costs nothing.
#if LIDAR_MAPPING_CERES_HAS_MANIFOLD
class TangentUpdate : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseBlockSize; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* d, double* x_plus_d) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};
#else
class TangentUpdate : public ceres::LocalParameterization {
 public:
  int GlobalSize() const override { return kPoseBlockSize; }
  int LocalSize() const override { return 6; }
  bool Plus(const double* x, const double* d, double* x_plus_d) const override;
  bool ComputeJacobian(const double* x, double* jacobian) const override;
};
#endif

/// Options under which the caller keeps costs, losses and updates.
ceres::Problem::Options non_owning_problem_options();
/// Adds a 3D state with its update.
void add_pose_block(ceres::Problem& problem, double* block, TangentUpdate& update);

}  // namespace lidar_mapping::pose_graph
