// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/pose_graph/pose_graph.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

namespace lidar_mapping::pose_graph {

/// How the normal equations of a pose graph are solved. Both ways lead to the same minimum.
enum class GraphMethod {
  kAutomatic,  ///< condensed for large graphs, flat for others
  kFlat,       ///< one sparse Cholesky factorisation of all nodes
  kCondensed   ///< piece by piece, see minimize_condensed(): less memory, several threads
};

/// How a pose graph from a file is solved.
struct GraphOptions {
  /// Kernel of the loops, which are the edges between ids that do not differ by 1. kNone is least
  /// squares.
  RobustKernel kernel = RobustKernel::kNone;
  double kernel_size = 1.0;  ///< scale of the kernel, standard deviations
  /// Decide which loops to use (solve_graduated()). The loops that are used keep their kernel.
  bool graduated = false;
  /// The solver ends if the next steps are expected to lower the cost by less than this fraction.
  /// It has no effect with `graduated`, which has fixed tolerances.
  double tolerance = 5e-4;
  GraphMethod method = GraphMethod::kAutomatic;  ///< how the equations are solved
  int threads = 0;  ///< of the condensed method; 0: all cores. The result does not depend on it
};

/// The result of optimize() in figures.
struct GraphReport {
  double initial_cost = 0.0;         ///< chi2 of all edges at the poses of the file
  double start_cost = 0.0;           ///< chi2 of all edges at the start values
  double final_cost = 0.0;           ///< chi2 of the used edges at the solution
  int iterations = 0;                ///< number of steps
  bool success = false;              ///< false if the solver failed
  std::string method;                ///< flat or condensed
  std::string start;                 ///< source of the start values: chordal, file or odometry
  std::vector<std::size_t> refused;  ///< numbers of the edges that the others contradict
  std::string message;               ///< why the solver ended
};

/// Minimises the cost of the graph and updates its poses; the first node is fixed. Least squares
/// starts from the chordal relaxation. Robust solving starts from the odometry chain, because a
/// single false loop distorts the chordal relaxation.
GraphReport optimize(PoseGraph& graph, const GraphOptions& options = {});

}  // namespace lidar_mapping::pose_graph
