// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Start values as from initialize_chordally(), for large graphs: the relaxation is solved for
/// one node in each piece of the odometry chain, with loops moved to these nodes along the chain,
/// and followed by Gauss-Newton steps of these nodes. The nodes between them follow the odometry.
/// Returns false and leaves the graph as it is if that has no solution.
bool initialize_coarsely(PoseGraph& graph, int threads);

}  // namespace lidar_mapping::pose_graph
