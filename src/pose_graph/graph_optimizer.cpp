// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/graph_optimizer.hpp"

#include <cmath>
#include <future>
#include <optional>
#include <utility>

#include "lidar_mapping/pose_graph/robust_solver.hpp"

#include "condensed/condensed_minimizer.hpp"
#include "condensed/condensed_system.hpp"
#include "condensed/pose_graph_problem.hpp"
#include "initialization/chordal_initialization.hpp"
#include "initialization/coarse_initialization.hpp"
#include "initialization/odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Nodes from which on the condensed method is the default. Chosen: see doc/results/back_end.md.
constexpr std::size_t kCondensedNodes = 20000;

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
    Constraint constraint{residual_of(graph.edges[i], graph.planar), ends[i].first, ends[i].second};
    if (!is_odometry(graph.edges[i])) {
      constraint.switchable = options.graduated;
      constraint.kernel = options.kernel;
    }
    constraint.kernel_size = options.kernel_size;
    factors.add(std::move(constraint));
  }
  return factors;
}

void set_states(const PoseGraph& graph, FactorGraph& factors) {
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    factors.set_pose(static_cast<int>(i), graph.nodes[i].pose);
  }
}

bool is_robust(const GraphOptions& options) {
  return options.graduated || options.kernel != RobustKernel::kNone;
}

bool is_condensed(const PoseGraph& graph, const GraphOptions& options) {
  if (options.method != GraphMethod::kAutomatic) return options.method == GraphMethod::kCondensed;
  return graph.nodes.size() >= kCondensedNodes;
}

/// Sets the start values of the graph and returns the name of their source.
std::string start(PoseGraph& graph, const GraphOptions& options) {
  if (!is_robust(options)) {
    const bool done = is_condensed(graph, options) ? initialize_coarsely(graph, options.threads)
                                                   : initialize_chordally(graph);
    return done ? "chordal" : "file";
  }
  initialize_along_edges(graph, {std::vector<bool>(graph.nodes.size(), false)});
  return "odometry";
}

MinimizerSettings settings_of(const GraphOptions& options) {
  // With a robust kernel, undamped steps may jump to distant minima.
  const auto radius = options.kernel == RobustKernel::kNone ? std::nullopt : std::optional(1e4);
  return {100, radius, options.tolerance, {}};
}

RobustSolution solve(FactorGraph& factors, const GraphOptions& options, bool condensed) {
  if (options.graduated) return solve_graduated(factors, {condensed, options.threads});
  const std::vector<bool> all(factors.constraints.size(), true);
  return solve_selected(factors, all, settings_of(options));
}

GraphReport optimize_factors(PoseGraph& graph, const GraphOptions& options) {
  GraphReport report;
  FactorGraph factors = make_factors(graph, options);
  const std::vector<bool> all(factors.constraints.size(), true);
  report.initial_cost = total_chi2(factors, all);
  report.start = start(graph, options);
  set_states(graph, factors);
  report.start_cost = total_chi2(factors, all);
  const RobustSolution solution = solve(factors, options, is_condensed(graph, options));
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

/// chi2 of all edges at the poses of the graph.
template <int size>
double total_chi2(PoseGraph& graph, int threads) {
  return total_cost<size>(*make_condensed_problem<size>(graph, RobustKernel::kNone, 1.0), threads);
}

/// Works on the graph itself, because factors of a million edges would take most of the memory.
template <int size>
GraphReport optimize_edges(PoseGraph& graph, const GraphOptions& options) {
  GraphReport report;
  report.initial_cost = total_chi2<size>(graph, options.threads);
  // How nodes are eliminated does not depend on the start, which does not keep all cores busy.
  const auto shape = make_condensed_problem<size>(graph, RobustKernel::kNone, 1.0);
  const auto policy = options.threads == 1 ? std::launch::deferred : std::launch::async;
  std::future<CondensedStructure> structure =
      std::async(policy, [&] { return condensed_structure<size>(*shape, options.threads); });
  report.start = start(graph, options);
  const double start_cost = is_robust(options) ? total_chi2<size>(graph, options.threads) : 0.0;
  const auto problem = make_condensed_problem<size>(graph, options.kernel, options.kernel_size);
  const MinimizerSummary summary =
      minimize_condensed<size>(*problem, structure.get(), settings_of(options), options.threads);
  // Under a kernel, the cost of the minimisation is not that of the edges.
  const bool plain = options.kernel == RobustKernel::kNone;
  report.start_cost = plain ? summary.initial_cost : start_cost;
  report.final_cost = plain ? summary.final_cost : total_chi2<size>(graph, options.threads);
  report.iterations = summary.iterations;
  report.success = summary.usable;
  report.message = summary.message;
  return report;
}

}  // namespace

GraphReport optimize(PoseGraph& graph, const GraphOptions& options) {
  GraphReport report;
  const bool condensed = is_condensed(graph, options);
  if (!condensed || options.graduated) {
    report = optimize_factors(graph, options);
  } else if (graph.planar) {
    report = optimize_edges<3>(graph, options);
  } else {
    report = optimize_edges<6>(graph, options);
  }
  report.method = condensed ? "condensed" : "flat";
  return report;
}

}  // namespace lidar_mapping::pose_graph
