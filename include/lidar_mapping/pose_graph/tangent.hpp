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

namespace lidar_mapping::pose_graph {

/// The state of a node as a parameter block of Ceres: x y z qx qy qz qw, or x y yaw in a planar
/// graph.
using StateBlock = std::array<double, 7>;
constexpr int kPoseBlockSize = 7;    ///< of a 3D node, by its layout: position and quaternion
constexpr int kPlanarBlockSize = 3;  ///< of a planar node, by its layout: x, y, yaw

/// The state of a 3D node with this pose.
StateBlock to_block(const Pose& pose);
/// The pose of a 3D state; the quaternion is normalised.
Pose to_pose(const double* block);
/// The state of a planar node with x, y and yaw of this pose.
StateBlock to_planar_block(const Pose& pose);
/// The pose of a planar state, with z, roll and pitch zero.
Pose to_planar_pose(const double* block);

/// The 3D state after the update d = (dt, v): T * (dt, (sqrt(1 - v^2), v)). For small angles v is
/// half a rotation vector, as in g2o (doc/back_end.md).
StateBlock retract(const double* block, const double* d);

#if LIDAR_MAPPING_CERES_HAS_MANIFOLD
/// retract() as a manifold of Ceres. Residuals write their derivatives by d into the first six
/// columns of a Jacobian of seven columns, and zero into the last column. The derivative of the
/// update is therefore the identity above a row of zeros, which needs no computation.
class TangentUpdate : public ceres::Manifold {
 public:
  /// Numbers of a state.
  int AmbientSize() const override { return kPoseBlockSize; }
  /// Numbers of an update.
  int TangentSize() const override { return 6; }
  /// The state after the update d, see retract().
  bool Plus(const double* x, const double* d, double* x_plus_d) const override;
  /// The identity above a row of zeros, 7 x 6.
  bool PlusJacobian(const double* x, double* jacobian) const override;
  /// The update that leads from x to y.
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  /// The identity beside a column of zeros, 6 x 7.
  bool MinusJacobian(const double* x, double* jacobian) const override;
};
#else
/// retract() as a local parameterization of Ceres. Residuals write their derivatives by d into the
/// first six columns of a Jacobian of seven columns, and zero into the last column. The derivative
/// of the update is therefore the identity above a row of zeros, which needs no computation.
class TangentUpdate : public ceres::LocalParameterization {
 public:
  /// Numbers of a state.
  int GlobalSize() const override { return kPoseBlockSize; }
  /// Numbers of an update.
  int LocalSize() const override { return 6; }
  /// The state after the update d, see retract().
  bool Plus(const double* x, const double* d, double* x_plus_d) const override;
  /// The identity above a row of zeros, 7 x 6.
  bool ComputeJacobian(const double* x, double* jacobian) const override;
};
#endif

}  // namespace lidar_mapping::pose_graph
