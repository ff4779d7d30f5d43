// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/graph_optimizer.hpp"

#include <cmath>
#include <optional>

#include "lidar_mapping/pose_graph/robust_solver.hpp"

#include "chordal_initialization.hpp"
#include "odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

CostPtr residual_of(const PoseEdge& edge, bool planar) {
  if (!planar) return relative_pose_residual(edge.T_from_to, edge.information);
  const Pose& T = edge.T_from_to;
  Eigen::Matrix3d information;
  information << edge.information.topLeftCorner<2, 2>(), edge.information.block<2, 1>(0, 5),
      edge.information.block<1, 2>(5, 0), edge.information(5, 5);
  return planar_relative_pose_residual({T.translation.x(), T.translation.y(), yaw_of(T.rotation)},
                                       information);
}

FactorGraph make_factors(const PoseGraph& graph, const GraphOptions& options) {
  FactorGraph factors;
  factors.planar = graph.planar;
  factors.states.reserve(graph.nodes.size());
  factors.constraints.reserve(graph.edges.size());
  for (const PoseNode& node : graph.nodes) {
    factors.add_node(node.pose, &node == &graph.nodes.front());
  }
  const auto ends = edge_positions(graph);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const bool loop = !is_odometry(graph.edges[i]);
    factors.add({residual_of(graph.edges[i], graph.planar), ends[i].first, ends[i].second,
                 loop && options.graduated, loop ? options.kernel : RobustKernel::kNone,
                 options.kernel_size});
  }
  return factors;
}

void set_states(const PoseGraph& graph, FactorGraph& factors) {
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    factors.set_pose(static_cast<int>(i), graph.nodes[i].pose);
  }
}

/// Sets the start values of the graph and returns the name of their source.
std::string start(PoseGraph& graph, const GraphOptions& options) {
  if (!options.graduated && options.kernel == RobustKernel::kNone) {
    return initialize_chordally(graph) ? "chordal" : "file";
  }
  initialize_along_edges(graph, {std::vector<bool>(graph.nodes.size(), false)});
  return "odometry";
}

RobustSolution solve(FactorGraph& factors, const GraphOptions& options) {
  if (options.graduated) return solve_graduated(factors);
  const std::vector<bool> all(factors.constraints.size(), true);
  // With a robust kernel, undamped steps may jump to distant minima.
  const auto radius = options.kernel == RobustKernel::kNone ? std::nullopt : std::optional(1e4);
  return solve_selected(factors, all, {100, radius, options.tolerance});
}

}  // namespace

GraphReport optimize(PoseGraph& graph, const GraphOptions& options) {
  GraphReport report;
  FactorGraph factors = make_factors(graph, options);
  const std::vector<bool> all(factors.constraints.size(), true);
  report.initial_cost = total_chi2(factors, all);
  report.start = start(graph, options);
  set_states(graph, factors);
  report.start_cost = total_chi2(factors, all);
  const RobustSolution solution = solve(factors, options);
  report.final_cost = solution.cost_after;
  report.iterations = solution.iterations;
  report.success = solution.success;
  report.message = solution.message;
  for (std::size_t i = 0; i < solution.used.size(); ++i) {
    if (!solution.used[i]) report.refused.push_back(i);
  }
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    graph.nodes[i].pose = factors.pose(static_cast<int>(i));
  }
  return report;
}

}  // namespace lidar_mapping::pose_graph
