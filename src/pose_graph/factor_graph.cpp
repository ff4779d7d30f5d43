// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/factor_graph.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <ceres/problem.h>
#include <ceres/solver.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pose_graph/condensed_solver.hpp"

#include "linear_algebra/single_threaded_openmp.hpp"
#include "solvers/gauss_newton.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// SuiteSparse is faster for dense factors and not slower for others.
ceres::SparseLinearAlgebraLibraryType sparse_library() {
  return ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE)
             ? ceres::SUITE_SPARSE
             : ceres::EIGEN_SPARSE;
}

// Radius of a trust region that does not limit steps, m. Chosen: larger than any drive.
constexpr double kWideRadius = 1e10;

ceres::Solver::Options solver_options(const MinimizerSettings& settings) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = sparse_library();
  options.initial_trust_region_radius = settings.initial_radius.value_or(kWideRadius);
  options.max_trust_region_radius = 1e32;
  // Ceres discards the step with which this test ends; ConvergenceCallback ends one step earlier.
  options.function_tolerance = 1e-3 * settings.tolerance;
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 1e-12;
  options.max_num_iterations = settings.max_iterations;
  // One thread: with several, the order of summation changes from run to run.
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

/// Ends a minimisation one step before the test of Ceres. Near the minimum the ratio of the next
/// gain to the last one is at most that of the last gain to the one before.
class ConvergenceCallback : public ceres::IterationCallback {
 public:
  explicit ConvergenceCallback(double tolerance) : tolerance_(tolerance) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
    if (step.iteration == 0 || !step.step_is_successful) return ceres::SOLVER_CONTINUE;
    const double rate = last_gain_ > 0.0 ? std::min(1.0, step.cost_change / last_gain_) : 1.0;
    last_gain_ = step.cost_change;
    const bool is_converged = step.cost_change * rate < tolerance_ * step.cost;
    return is_converged ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  double tolerance_;
  double last_gain_ = 0.0;
};

/// Options of a problem that does not own its cost functions, losses and manifolds.
ceres::Problem::Options non_owning_problem_options() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
#if LIDAR_MAPPING_CERES_HAS_MANIFOLD
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
#else
  options.local_parameterization_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
#endif
  options.disable_all_safety_checks = true;
  return options;
}

/// The Ceres problem of a graph; it is built and solved once.
class GraphProblem {
 public:
  explicit GraphProblem(FactorGraph& graph)
      : graph_(graph), problem_(non_owning_problem_options()), added_(graph.states.size(), false) {}

  void add(const Constraint& constraint, ceres::LossFunction* loss) {
    double* first = block(constraint.first);
    if (!constraint.is_binary()) {
      problem_.AddResidualBlock(constraint.residual.get(), loss, first);
      return;
    }
    double* second = block(constraint.second);
    problem_.AddResidualBlock(constraint.residual.get(), loss, first, second);
  }

  MinimizerSummary solve(const MinimizerSettings& settings) {
    ConvergenceCallback is_converged(settings.tolerance);
    ceres::Solver::Options options = solver_options(settings);
    options.callbacks.push_back(&is_converged);
    ceres::Solver::Summary summary;
    const SingleThreadedOpenMp single_threaded;
    ceres::Solve(options, &problem_, &summary);
    MinimizerSummary result;
    result.initial_cost = 2.0 * summary.initial_cost;
    result.final_cost = 2.0 * summary.final_cost;
    result.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps - 1;
    result.usable = summary.IsSolutionUsable();
    result.message = summary.message;
    return result;
  }

 private:
  double* block(int node) {
    const auto slot = static_cast<std::size_t>(node);
    double* state = graph_.states[slot].data();
    if (added_[slot]) return state;
    added_[slot] = true;
    if (graph_.planar) {
      problem_.AddParameterBlock(state, kPlanarBlockSize);
    } else {
      problem_.AddParameterBlock(state, kPoseBlockSize, &update_);
    }
    if (graph_.fixed[slot]) problem_.SetParameterBlockConstant(state);
    return state;
  }

  FactorGraph& graph_;
  TangentUpdate update_;
  ceres::Problem problem_;
  std::vector<bool> added_;
};

/// The reason why a constraint cannot be solved with the graph; empty if there is none.
std::string validation_error(const Constraint& constraint, const FactorGraph& graph) {
  if (constraint.residual == nullptr) return "has no residual; give it a ceres::CostFunction";
  const int rows = constraint.degrees_of_freedom();
  if (rows < 1 || rows > kMaxResidualRows) {
    return "has a residual of " + std::to_string(rows) + " rows; 1 to " +
           std::to_string(kMaxResidualRows) + " are solved, so split it into several constraints";
  }
  const std::vector<std::int32_t> expected(constraint.is_binary() ? 2 : 1,
                                           graph.planar ? kPlanarBlockSize : kPoseBlockSize);
  if (constraint.residual->parameter_block_sizes() != expected) {
    return "has a residual with other blocks than " + std::to_string(expected.size()) + " of " +
           std::to_string(expected.front()) + " numbers; it must take one for each of its nodes";
  }
  const int nodes = static_cast<int>(graph.states.size());
  if (constraint.first < 0 || std::max(constraint.first, constraint.second) >= nodes) {
    return "is between nodes " + std::to_string(constraint.first) + " and " +
           std::to_string(constraint.second) + ", but there are " + std::to_string(nodes) +
           "; add the nodes first";
  }
  return "";
}

}  // namespace

int FactorGraph::add(Constraint constraint) {
  const std::string problem = validation_error(constraint, *this);
  if (!problem.empty()) {
    throw InputError("constraint " + std::to_string(constraints.size()) + " " + problem);
  }
  constraints.push_back(std::move(constraint));
  return static_cast<int>(constraints.size()) - 1;
}

int FactorGraph::add(Constraint constraint, RobustKernel kernel, double kernel_size) {
  constraint.kernel = kernel;
  constraint.kernel_size = kernel_size;
  return add(std::move(constraint));
}

int FactorGraph::add_node(const Pose& pose, bool is_fixed) {
  states.push_back(planar ? to_planar_block(pose) : to_block(pose));
  fixed.push_back(is_fixed);
  return static_cast<int>(states.size()) - 1;
}

Pose FactorGraph::pose(int node) const {
  const double* block = states[node].data();
  return planar ? to_planar_pose(block) : to_pose(block);
}

void FactorGraph::set_pose(int node, const Pose& pose) {
  states[node] = planar ? to_planar_block(pose) : to_block(pose);
}

void evaluate(const FactorGraph& graph, const Constraint& constraint, double* residual,
              double** jacobians) {
  const int second = constraint.is_binary() ? constraint.second : constraint.first;
  const std::array<const double*, 2> blocks = {graph.states[constraint.first].data(),
                                               graph.states[second].data()};
  constraint.residual->Evaluate(blocks.data(), residual, jacobians);
}

double chi2(const FactorGraph& graph, const Constraint& constraint) {
  std::array<double, kMaxResidualRows> residual{};
  evaluate(graph, constraint, residual.data(), nullptr);
  double sum = 0.0;
  for (int i = 0; i < constraint.degrees_of_freedom(); ++i) {
    sum += residual[i] * residual[i];
  }
  return sum;
}

double total_chi2(const FactorGraph& graph, const std::vector<bool>& used) {
  double sum = 0.0;
  for (std::size_t i = 0; i < graph.constraints.size(); ++i) {
    if (used[i]) sum += chi2(graph, graph.constraints[i]);
  }
  return sum;
}

MinimizerSummary minimize(FactorGraph& graph, const std::vector<bool>& used, const LossOf& loss_of,
                          const MinimizerSettings& settings) {
  if (settings.solver.condensed) {
    return minimize_condensed(graph, used, loss_of, settings, settings.solver.threads);
  }
  const std::vector<StateBlock> before = graph.states;
  MinimizerSummary undamped;
  if (!settings.initial_radius) {
    undamped = gauss_newton(graph, used, loss_of, settings);
    if (undamped.usable) return undamped;
  }
  GraphProblem problem(graph);
  for (std::size_t i = 0; i < graph.constraints.size(); ++i) {
    if (used[i]) problem.add(graph.constraints[i], loss_of(graph.constraints[i]));
  }
  MinimizerSummary summary = problem.solve(settings);
  if (!settings.initial_radius) summary.initial_cost = undamped.initial_cost;
  summary.iterations += undamped.iterations;
  if (!summary.usable) graph.states = before;
  return summary;
}

}  // namespace lidar_mapping::pose_graph
