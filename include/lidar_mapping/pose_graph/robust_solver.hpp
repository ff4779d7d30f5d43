// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

struct RobustSolution {
  std::vector<bool> used;    ///< per constraint; false: refused, the others contradict it
  double cost_before = 0.0;  ///< chi2 of the used constraints at the start
  double cost_after = 0.0;
  int iterations = 0;
  bool success = false;
  std::string message;
};

/// The graph with every constraint that `used` marks, each under its own kernel, from the present
/// states.
RobustSolution solve_selected(FactorGraph& graph, std::vector<bool> used,
                              const MinimizerSettings& settings = {});

/// Decides which switchable constraints to believe and solves with them: Cauchy, then dynamic
/// covariance scaling, then refusal above twice the 99 % quantile and least squares, in rounds in
/// which refused ones may return. Starts from the present states, which should follow the
/// constraints that are not switchable (the odometry chain): those are what the others are judged
/// by.
RobustSolution solve_graduated(FactorGraph& graph);

/// Marks of all constraints that are not switchable, and of switchable ones that agree with the
/// present states.
std::vector<bool> consistent_constraints(const FactorGraph& graph);

}  // namespace lidar_mapping::pose_graph
