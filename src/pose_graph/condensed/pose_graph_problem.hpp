// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "lidar_mapping/pose_graph/pose_graph.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

#include "condensed/condensed_problem.hpp"

namespace lidar_mapping::pose_graph {

/// The relative poses of a graph as they stand in a file, without a residual object for each. The
/// first node is fixed. Loops, which are the edges between ids that do not differ by 1, have the
/// kernel. The graph has to live as long as the problem, which moves its poses. `size` is 6, or 3
/// for a planar graph.
template <int size>
std::unique_ptr<CondensedProblem<size>> make_condensed_problem(PoseGraph& graph,
                                                               RobustKernel kernel,
                                                               double kernel_size);

}  // namespace lidar_mapping::pose_graph
