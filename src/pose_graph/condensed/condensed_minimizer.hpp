// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

#include "condensed/condensed_problem.hpp"
#include "condensed/condensed_system.hpp"

namespace lidar_mapping::pose_graph {

/// Minimises the cost of a problem by steps of CondensedSystem, see minimize_condensed(). If it
/// fails, the states are those of the least cost that was found.
template <int size>
MinimizerSummary minimize_condensed(CondensedProblem<size>& problem, CondensedStructure structure,
                                    const MinimizerSettings& settings, int threads);

}  // namespace lidar_mapping::pose_graph
