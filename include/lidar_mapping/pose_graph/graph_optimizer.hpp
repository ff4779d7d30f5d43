// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/pose_graph/pose_graph.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

namespace lidar_mapping::pose_graph {

/// What a pose graph from a file is solved under.
struct GraphOptions {
  /// On loops (edges between ids that are not neighbours); kNone is plain least squares.
  RobustKernel kernel = RobustKernel::kNone;
  double kernel_size = 1.0;  ///< standard deviations
  /// Decide which loops to believe (solve_graduated); the kernel then has no effect.
  bool graduated = false;
  /// Relative to the cost: ends with the step that is expected to gain less. Without effect on
  /// `graduated`, whose rounds have tolerances of their own.
  double tolerance = 5e-4;
};

struct GraphReport {
  double initial_cost = 0.0;  ///< g2o's chi2 of all edges, at the file's poses
  double start_cost = 0.0;    ///< at the start values
  double final_cost = 0.0;    ///< of the edges that are believed
  int iterations = 0;
  bool success = false;
  std::string start;                 ///< chordal, file or odometry
  std::vector<std::size_t> refused;  ///< edges that the others contradict
  std::string message;
};

/// Moves the nodes to the least cost; the first one is held. Least squares starts from the chordal
/// relaxation, robust solving from the odometry chain, because a single false loop spoils the
/// former.
GraphReport optimize(PoseGraph& graph, const GraphOptions& options = {});

}  // namespace lidar_mapping::pose_graph
