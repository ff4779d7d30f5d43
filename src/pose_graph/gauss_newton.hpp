// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Undamped steps on a graph whose pattern is analysed once. A constraint under a kernel counts
/// with the kernel's slope at the present residual (iteratively reweighted least squares). Keeps
/// the states from before a step that does not lower the cost; `usable` is true if the minimum was
/// reached, false if something better has to go on from there.
MinimizerSummary gauss_newton(FactorGraph& graph, const std::vector<bool>& used,
                              const LossOf& loss_of, const MinimizerSettings& settings);

}  // namespace lidar_mapping::pose_graph
