// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/robust_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <ceres/loss_function.h>

namespace lidar_mapping::pose_graph {

namespace {

constexpr int kMaxRounds = 5;  // chosen: the choice may alternate without end
// Real errors have heavier tails than a Gaussian, and false loops have much larger residuals. A
// constraint is therefore refused only above twice the quantile. Chosen: otherwise one per cent or
// more of the true ones would be refused.
constexpr double kRefusalFactor = 2.0;
// Weights of the constraints that are not switchable. They are tried in turn until half of the
// switchable constraints are used.
constexpr std::array<double, 3> kFixedConstraintWeights = {1.0, 0.04, 0.0016};

/// Losses by kernel and size, created once and kept while a problem uses them.
class Kernels {
 public:
  using Losses = std::map<std::pair<RobustKernel, double>, std::unique_ptr<ceres::LossFunction>>;

  ceres::LossFunction* get(RobustKernel kernel, double size) {
    auto& loss = losses_[{kernel, size}];
    if (!loss) loss = make_kernel(kernel, size);
    return loss.get();
  }

  /// The same loss with the least weight.
  ceres::LossFunction* get_downweighted(RobustKernel kernel, double size) {
    auto& loss = downweighted_[{kernel, size}];
    if (!loss) {
      loss = std::make_unique<ceres::ScaledLoss>(get(kernel, size), kFixedConstraintWeights.back(),
                                                 ceres::DO_NOT_TAKE_OWNERSHIP);
    }
    return loss.get();
  }

 private:
  Losses losses_;
  Losses downweighted_;
};

/// Each constraint under its own kernel.
LossOf own_kernel_losses(Kernels& kernels) {
  return [&kernels](const Constraint& c) { return kernels.get(c.kernel, c.kernel_size); };
}

/// First stage: switchable constraints under Cauchy kernels of one standard deviation, which
/// attract from far away. The other constraints have a reduced weight, so that they give way to a
/// drift that their covariances do not include. Doubtful constraints have the least weight, because
/// they are no evidence against others.
LossOf cauchy_stage_losses(Kernels& kernels, ceres::LossFunction* other_loss) {
  return [&kernels, other_loss](const Constraint& c) {
    if (c.doubtful) return kernels.get_downweighted(c.kernel, c.kernel_size);
    return c.switchable ? kernels.get(RobustKernel::kCauchy, 1.0) : other_loss;
  };
}

/// Second stage: switchable constraints under DCS with chi2_limit() as scale.
LossOf dcs_stage_losses(Kernels& kernels) {
  return [&kernels](const Constraint& c) {
    if (c.doubtful) return kernels.get_downweighted(c.kernel, c.kernel_size);
    return c.switchable
               ? kernels.get(RobustKernel::kDcs, std::sqrt(chi2_limit(c.degrees_of_freedom())))
               : kernels.get(c.kernel, c.kernel_size);
  };
}

}  // namespace

std::vector<bool> consistent_constraints(const FactorGraph& graph) {
  std::vector<bool> used;
  used.reserve(graph.constraints.size());
  for (const Constraint& c : graph.constraints) {
    used.push_back(!c.switchable ||
                   chi2(graph, c) < kRefusalFactor * chi2_limit(c.degrees_of_freedom()));
  }
  return used;
}

RobustSolution solve_selected(FactorGraph& graph, std::vector<bool> used,
                              const MinimizerSettings& settings) {
  Kernels kernels;
  RobustSolution solution;
  solution.cost_before = total_chi2(graph, used);
  const MinimizerSummary summary = minimize(graph, used, own_kernel_losses(kernels), settings);
  solution.cost_after = total_chi2(graph, used);
  solution.iterations = summary.iterations;
  solution.success = summary.usable;
  solution.message = summary.message;
  solution.used = std::move(used);
  return solution;
}

namespace {

/// One run of both stages and of the rounds after them, from the current states.
RobustSolution run_graduated(FactorGraph& graph, double other_weight, const LinearSolver& solver) {
  Kernels kernels;
  ceres::ScaledLoss other_loss(nullptr, other_weight, ceres::TAKE_OWNERSHIP);
  const std::vector<bool> all(graph.constraints.size(), true);
  int iterations =
      minimize(graph, all, cauchy_stage_losses(kernels, &other_loss), {60, 1e4, 1e-5, solver})
          .iterations;
  iterations += minimize(graph, all, dcs_stage_losses(kernels), {60, 1e6, 1e-5, solver}).iterations;
  MinimizerSettings settings;
  settings.solver = solver;
  RobustSolution solution;
  std::vector<bool> used = consistent_constraints(graph);
  for (int round = 0; round < kMaxRounds; ++round) {
    solution = solve_selected(graph, used, settings);
    iterations += solution.iterations;
    used = consistent_constraints(graph);
    if (used == solution.used) break;
  }
  solution.iterations = iterations;
  return solution;
}

std::ptrdiff_t switchable_count(const FactorGraph& graph) {
  return std::count_if(graph.constraints.begin(), graph.constraints.end(),
                       [](const Constraint& c) { return c.switchable; });
}

std::ptrdiff_t refused_count(const RobustSolution& solution) {
  return std::count(solution.used.begin(), solution.used.end(), false);
}

}  // namespace

RobustSolution solve_graduated(FactorGraph& graph, const LinearSolver& solver) {
  const std::vector<StateBlock> start = graph.states;
  std::vector<StateBlock> best_states = start;
  RobustSolution best;
  for (const double weight : kFixedConstraintWeights) {
    graph.states = start;
    RobustSolution solution = run_graduated(graph, weight, solver);
    if (!best.success || (solution.success && refused_count(solution) < refused_count(best))) {
      best = std::move(solution);
      best_states = graph.states;
    }
    if (2 * refused_count(best) <= switchable_count(graph)) break;
  }
  graph.states = start;
  best.cost_before = best.success ? total_chi2(graph, best.used) : 0.0;
  graph.states = best_states;
  return best;
}

}  // namespace lidar_mapping::pose_graph
