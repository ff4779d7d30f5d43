// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Positions of the two ends of each edge in graph.nodes, which are ordered by id.
std::vector<std::pair<int, int>> edge_positions(const PoseGraph& graph);

/// True for an edge between neighbouring ids: odometry, as opposed to loops.
bool is_odometry(const PoseEdge& edge);

/// Computes the poses of the nodes that are not `placed` along the edges from those that are, or
/// from the first node. Edges of odometry are followed as far as possible, others only across gaps.
void initialize_along_edges(PoseGraph& graph, std::vector<bool> initialized);

}  // namespace lidar_mapping::pose_graph
