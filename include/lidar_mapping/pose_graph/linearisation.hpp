// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/pose_graph/block_cholesky.hpp"
#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// A constraint at the present states: its whitened residual and the derivatives with respect to
/// its nodes' tangents (those of a second node are zero where there is none).
struct LinearisedConstraint {
  Eigen::VectorXd residual;
  Eigen::MatrixXd first;
  Eigen::MatrixXd second;
};
LinearisedConstraint linearise(const FactorGraph& graph, const Constraint& constraint);

/// By what its kernel multiplies the pull of a constraint with this whitened residual.
double kernel_weight(const Constraint& constraint, const Eigen::VectorXd& residual);

/// The information matrix of all marked constraints at the present states, without kernels; but a
/// doubtful constraint tells as little as its kernel has left of it. There is room in it for
/// `more_pairs` of nodes, too.
std::unique_ptr<BlockCholesky<6>> information_matrix(
    const FactorGraph& graph, const std::vector<bool>& selected,
    const std::vector<std::pair<int, int>>& more_pairs = {});

}  // namespace lidar_mapping::pose_graph
