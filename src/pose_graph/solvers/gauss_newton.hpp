// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// A minimal damping of this and of the condensed minimisation: diagonal entries are larger by this
/// fraction. Chosen just above the rounding errors of doubles, so that directions that are
/// determined by these alone do not move. Measured: 1e-10 holds the softest bends of a long drive,
/// so that a graph of 100 000 key frames needs 33 steps instead of 5.
constexpr double kDiagonalScaling = 1e-14;

/// Minimises by undamped Gauss-Newton steps; the pattern of the graph is analysed once. A
/// constraint with a kernel is weighted by the derivative of its loss (iteratively reweighted least
/// squares). A step that does not decrease the cost is undone. `usable` is true if the minimum was
/// reached, and false if another method has to continue from these states.
MinimizerSummary gauss_newton(FactorGraph& graph, const std::vector<bool>& used,
                              const LossOf& loss_of, const MinimizerSettings& settings);

}  // namespace lidar_mapping::pose_graph
