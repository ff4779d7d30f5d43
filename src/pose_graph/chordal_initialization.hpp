// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Start values from two linear solves, whatever the nodes' poses are: rotations relaxed to
/// matrices (chordal relaxation, Carlone 2015), then translations. The first node stays where it
/// is. For graphs without false edges only: one of them spoils everything. False, and the graph as
/// it was, if the graph falls apart.
bool initialize_chordally(PoseGraph& graph);

}  // namespace lidar_mapping::pose_graph
