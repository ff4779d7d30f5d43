#include "lidar_mapping/back_end/robust_solver.hpp"

#include <cmath>
#include <map>

namespace lidar_mapping::back_end {

namespace {

constexpr int kRounds = 5;
// Real errors have heavier tails than Gauss' while false loops lie far out: refusal begins at twice
// the quantile, or a hundredth and more of the true ones would go.
constexpr double kRefusal = 2.0;

/// Losses by kernel and size, made once and kept while a problem uses them.
class Kernels {
 public:
  ceres::LossFunction* get(RobustKernel kernel, double size) {
    auto& loss = losses_[{kernel, size}];
    if (!loss) loss = make_kernel(kernel, size);
    return loss.get();
  }

 private:
  std::map<std::pair<RobustKernel, double>, std::unique_ptr<ceres::LossFunction>> losses_;
};

/// All constraints under their own kernels.
LossOf own_kernels(Kernels& kernels) {
  return [&kernels](const Constraint& c) { return kernels.get(c.kernel, c.kernel_size); };
}

/// Switchable constraints under Cauchy with one standard deviation: it still pulls from far away.
LossOf pulling(Kernels& kernels) {
  return [&kernels](const Constraint& c) {
    return c.switchable ? kernels.get(RobustKernel::kCauchy, 1.0)
                        : kernels.get(c.kernel, c.kernel_size);
  };
}

/// Switchable constraints under DCS that bends at the limit of contradiction.
LossOf deciding(Kernels& kernels) {
  return [&kernels](const Constraint& c) {
    return c.switchable ? kernels.get(RobustKernel::kDcs,
                                      std::sqrt(contradiction_limit(c.degrees_of_freedom())))
                        : kernels.get(c.kernel, c.kernel_size);
  };
}

}  // namespace

std::vector<bool> believed(const FactorGraph& graph) {
  std::vector<bool> used;
  used.reserve(graph.constraints.size());
  for (const Constraint& c : graph.constraints) {
    used.push_back(!c.switchable ||
                   chi2(graph, c) < kRefusal * contradiction_limit(c.degrees_of_freedom()));
  }
  return used;
}

RobustSolution solve_as_marked(FactorGraph& graph, std::vector<bool> used,
                               const MinimizerSettings& settings) {
  Kernels kernels;
  RobustSolution solution;
  solution.cost_before = total_chi2(graph, used);
  const MinimizerSummary summary = minimize(graph, used, own_kernels(kernels), settings);
  solution.cost_after = total_chi2(graph, used);
  solution.iterations = summary.iterations;
  solution.success = summary.usable;
  solution.message = summary.message;
  solution.used = std::move(used);
  return solution;
}

RobustSolution solve_graduated(FactorGraph& graph) {
  Kernels kernels;
  const std::vector<StateBlock> start = graph.states;
  const std::vector<bool> all(graph.constraints.size(), true);
  int iterations = minimize(graph, all, pulling(kernels), {60, 1e4, 1e-5}).iterations;
  iterations += minimize(graph, all, deciding(kernels), {60, 1e6, 1e-5}).iterations;
  RobustSolution solution;
  std::vector<bool> used = believed(graph);
  for (int round = 0; round < kRounds; ++round) {
    solution = solve_as_marked(graph, used);
    iterations += solution.iterations;
    used = believed(graph);
    if (used == solution.used) break;
  }
  solution.iterations = iterations;
  const std::vector<StateBlock> end = std::exchange(graph.states, start);
  solution.cost_before = total_chi2(graph, solution.used);
  graph.states = end;
  return solution;
}

}  // namespace lidar_mapping::back_end
