// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace lidar_mapping::pose_graph {

/// The result of a robust solution; the states are in the graph.
struct RobustSolution {
  std::vector<bool> used;    ///< per constraint; false: not used, or refused
  double cost_before = 0.0;  ///< chi2 of the used constraints at the start
  double cost_after = 0.0;   ///< chi2 of the used constraints at the end
  int iterations = 0;        ///< number of steps in all rounds
  bool success = false;      ///< false if the minimisation failed
  std::string message;       ///< why the last minimisation ended
};

/// Solves with all constraints whose entry in `used` is true, each under its own kernel, starting
/// from the current states.
RobustSolution solve_selected(FactorGraph& graph, std::vector<bool> used,
                              const MinimizerSettings& settings = {});

/// Decides which switchable constraints to use, and solves with them (graduated solving, after Yang
/// et al. 2020). The switchable constraints are first under Cauchy kernels, then under dynamic
/// covariance scaling. Then those above twice chi2_limit() are refused and the others are solved
/// under their own kernels; this is repeated, and a refused constraint may be used again. The start
/// states must follow the constraints that are not switchable (the odometry chain), because the
/// switchable ones are compared with these. `solver` computes all steps.
RobustSolution solve_graduated(FactorGraph& graph, const LinearSolver& solver = {});

/// For each constraint: true if it is not switchable, or if its chi2() at the current states is
/// below twice chi2_limit().
std::vector<bool> consistent_constraints(const FactorGraph& graph);

}  // namespace lidar_mapping::pose_graph
