// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Minimises as minimize() does, to the same minimum, with a fraction of the memory and on several
/// threads (0: all cores; the result has the same bits for any number). The factor of the normal
/// equations is never kept: nodes are eliminated piece by piece, the condensed graph of the nodes
/// between the pieces is solved, and the pieces are solved back. This pays for large graphs, see
/// doc/back_end.md. Steps are undamped at first unless the settings give a trust region; where one
/// does not lower the cost, damped steps follow (Levenberg-Marquardt).
MinimizerSummary minimize_condensed(FactorGraph& graph, const std::vector<bool>& used,
                                    const LossOf& loss_of, const MinimizerSettings& settings,
                                    int threads = 0);

}  // namespace lidar_mapping::pose_graph
