// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/pose_graph/block_cholesky.hpp"
#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// A constraint at the current states. The derivatives are with respect to the updates of
/// tangent.hpp.
struct LinearisedConstraint {
  Eigen::VectorXd residual;  ///< whitened residual
  Eigen::MatrixXd first;     ///< derivative by the first node, 6 columns
  Eigen::MatrixXd second;    ///< derivative by the second node, 6 columns; 0 if there is none
};
/// Linearises one constraint of a graph of 3D poses, without kernel.
LinearisedConstraint linearise(const FactorGraph& graph, const Constraint& constraint);

/// Weight of a constraint under its kernel, 0 to 1: the derivative of the loss by the squared norm
/// of the whitened residual.
double kernel_weight(const Constraint& constraint, const Eigen::VectorXd& residual);

/// The information matrix of all selected constraints at the current states. Kernels are ignored,
/// except that a doubtful constraint is weighted by kernel_weight(). The pattern also contains
/// `more_pairs` of nodes.
std::unique_ptr<BlockCholesky<6>> information_matrix(
    const FactorGraph& graph, const std::vector<bool>& selected,
    const std::vector<std::pair<int, int>>& more_pairs = {});

}  // namespace lidar_mapping::pose_graph
