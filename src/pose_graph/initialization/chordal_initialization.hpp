// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Computes start values by two linear solutions, independently of the nodes' poses: first
/// rotations relaxed to matrices (chordal relaxation, Carlone 2015), then translations. The first
/// node keeps its pose. The graph must not contain false edges: a single one distorts the whole
/// solution. Returns false and changes nothing if the graph is not connected.
bool initialize_chordally(PoseGraph& graph);

}  // namespace lidar_mapping::pose_graph
