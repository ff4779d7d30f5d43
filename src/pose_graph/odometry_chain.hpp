// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Where each edge's ends stand in graph.nodes (which are ordered by id).
std::vector<std::pair<int, int>> edge_positions(const PoseGraph& graph);

/// True for the edges between neighbouring ids: a drive's odometry, as opposed to its loops.
bool is_odometry(const PoseEdge& edge);

/// Places the nodes that are not `placed` along the edges from those that are (or from the first
/// node): along odometry as far as it goes, over other edges only across its gaps.
void place_along_edges(PoseGraph& graph, std::vector<bool> placed);

}  // namespace lidar_mapping::pose_graph
