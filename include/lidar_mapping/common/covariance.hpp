// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping {

/// Covariance of a pose: translation (m), then rotation vector (rad), in the axes of the child
/// frame (the perturbation of perturbed()). Messages carry it row-major as x y z roll pitch yaw.
using Covariance6 = Matrix6d;

/// Diagonal covariance from standard deviations: `sigma_m` for each axis and `sigma_rad`.
Covariance6 diagonal_covariance(double sigma_m, double sigma_rad);

/// The covariance in the axes of the parent frame, as nav_msgs/Odometry wants it. The inverse pose
/// gives the reverse.
Covariance6 in_parent_axes(const Covariance6& covariance, const Pose& T_parent_child);

/// 6x6 adjoint of T for perturbations (translation, rotation): T * exp(d) = exp(adjoint(T) d) * T.
Matrix6d adjoint(const Pose& T);

/// Covariance of T_a_c = T_a_b * T_b_c from independent covariances of both.
Covariance6 compose_covariance(const Covariance6& of_T_a_b, const Pose& T_b_c,
                               const Covariance6& of_T_b_c);

/// True if finite, symmetric and positive definite.
bool is_valid_covariance(const Covariance6& covariance);

}  // namespace lidar_mapping
