// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Minimises by undamped Gauss-Newton steps; the pattern of the graph is analysed once. A
/// constraint with a kernel is weighted by the derivative of its loss (iteratively reweighted least
/// squares). A step that does not decrease the cost is undone. `usable` is true if the minimum was
/// reached, and false if another method has to continue from these states.
MinimizerSummary gauss_newton(FactorGraph& graph, const std::vector<bool>& used,
                              const LossOf& loss_of, const MinimizerSettings& settings);

}  // namespace lidar_mapping::pose_graph
