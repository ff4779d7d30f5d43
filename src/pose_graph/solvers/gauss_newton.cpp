// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/gauss_newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "lidar_mapping/pose_graph/block_cholesky.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Fraction of the cost: after a larger expected gain the factor is computed again. Chosen: an old
// factor still converges for less, and a step with it costs a small part of a factorisation.
constexpr double kRefactorizeGain = 1e-3;
// Fraction of the cost by which it may seem to rise at the minimum. Chosen: far above the rounding
// of sums of doubles, far below the tolerance at which the search ends.
constexpr double kCostRounding = 1e-9;

/// A constraint with its loss.
struct Term {
  const Constraint* constraint;
  ceres::LossFunction* loss;
  int pair;  ///< number of its block off the diagonal; -1: none, because a node is fixed
};

/// The normal equations of a graph; `size` is the dimension of a node's update.
template <int size>
class NormalEquations {
 public:
  // Columns of a Jacobian per node, by the layout of Ceres, which has one per number of the state.
  static constexpr int kBlock = size == 6 ? kPoseBlockSize : kPlanarBlockSize;
  using Block = Eigen::Matrix<double, size, size>;

  NormalEquations(const FactorGraph& graph, const std::vector<bool>& used, const LossOf& loss_of)
      : graph_(graph), constrained_(graph.states.size(), false) {
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i < graph.constraints.size(); ++i) {
      if (!used[i]) continue;
      const Constraint& constraint = graph.constraints[i];
      Term term{&constraint, loss_of(constraint), -1};
      mark_constrained(constraint.first);
      if (constraint.is_binary()) mark_constrained(constraint.second);
      if (constraint.is_binary() && moves(constraint.first) && moves(constraint.second)) {
        term.pair = static_cast<int>(pairs.size());
        pairs.emplace_back(constraint.first, constraint.second);
      }
      terms_.push_back(term);
    }
    cholesky_ = std::make_unique<BlockCholesky<size>>(static_cast<int>(graph.states.size()), pairs);
  }

  double cost() const {
    double sum = 0.0;
    for (const Term& term : terms_) sum += loss_at(term.loss, chi2(graph_, *term.constraint)).first;
    return sum;
  }

  /// Computes matrix and gradient at the current states; the factor stays that of an earlier state.
  void linearise() {
    cholesky_->set_zero();
    gradient_ = Eigen::VectorXd::Zero(size * static_cast<Eigen::Index>(graph_.states.size()));
    for (int node = 0; node < static_cast<int>(graph_.states.size()); ++node) {
      if (!moves(node)) cholesky_->add_diagonal(node, Block::Identity());
    }
    for (const Term& term : terms_) add(term);
  }
  /// Factorises the matrix. Returns false if it is not positive definite.
  bool factorize() { return cholesky_->factorize(); }
  /// The step to the minimum of the linearised cost, one segment per node.
  Eigen::VectorXd step() { return -cholesky_->solve(gradient_); }
  /// The decrease of the linearised cost over a step.
  double expected_gain(const Eigen::VectorXd& step) const { return -gradient_.dot(step); }

  bool moves(int node) const {
    const auto slot = static_cast<std::size_t>(node);
    return constrained_[slot] && !graph_.fixed[slot];
  }

 private:
  void mark_constrained(int node) { constrained_[node] = true; }

  void add(const Term& term) {
    switch (term.constraint->degrees_of_freedom()) {
      case 1:
        return add_rows<1>(term);
      case 2:
        return add_rows<2>(term);
      case 3:
        return add_rows<3>(term);
      case 4:
        return add_rows<4>(term);
      case 5:
        return add_rows<5>(term);
      default:  // FactorGraph::add() accepts no more rows
        return add_rows<kMaxResidualRows>(term);
    }
  }

  template <int rows>
  void add_rows(const Term& term) {
    using Jacobian = Eigen::Matrix<double, rows, kBlock, Eigen::RowMajor>;
    const Constraint& constraint = *term.constraint;
    std::array<Jacobian, 2> jacobians;
    Eigen::Matrix<double, rows, 1> residual;
    std::array<double*, 2> targets = {jacobians[0].data(), jacobians[1].data()};
    evaluate(graph_, constraint, residual.data(), targets.data());
    const double weight = loss_at(term.loss, residual.squaredNorm()).second;
    const Eigen::Matrix<double, rows, size> first = jacobians[0].template leftCols<size>();
    add_node(constraint.first, first, residual, weight);
    if (!constraint.is_binary()) return;
    const Eigen::Matrix<double, rows, size> second = jacobians[1].template leftCols<size>();
    add_node(constraint.second, second, residual, weight);
    if (term.pair < 0) return;
    const Block block = weight * (first.transpose() * second);
    cholesky_->add_pair(static_cast<std::size_t>(term.pair), block);
  }

  template <int rows>
  void add_node(int node, const Eigen::Matrix<double, rows, size>& jacobian,
                const Eigen::Matrix<double, rows, 1>& residual, double weight) {
    if (!moves(node)) return;
    Block block = weight * (jacobian.transpose() * jacobian);
    block.diagonal() *= 1.0 + kDiagonalScaling;
    cholesky_->add_diagonal(node, block);
    gradient_.segment<size>(size * static_cast<Eigen::Index>(node)).noalias() +=
        weight * (jacobian.transpose() * residual);
  }

  const FactorGraph& graph_;
  std::vector<bool> constrained_;
  std::vector<Term> terms_;
  std::unique_ptr<BlockCholesky<size>> cholesky_;
  Eigen::VectorXd gradient_;
};

StateBlock planar_retract(const StateBlock& state, const double* d) {
  return {state[0] + d[0], state[1] + d[1], state[2] + d[2], 0.0, 0.0, 0.0, 0.0};
}

template <int size>
std::vector<StateBlock> states_after(const FactorGraph& graph,
                                     const NormalEquations<size>& equations,
                                     const Eigen::VectorXd& step) {
  std::vector<StateBlock> states = graph.states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!equations.moves(static_cast<int>(i))) continue;
    const double* d = step.data() + size * i;
    states[i] = size == 6 ? retract(states[i].data(), d) : planar_retract(states[i], d);
  }
  return states;
}

/// The Gauss-Newton steps of one graph. The factor of an earlier state is reused while its steps
/// are small: such a step costs a fraction of one with a new factor.
template <int size>
class GaussNewtonSolver {
 public:
  GaussNewtonSolver(FactorGraph& graph, const std::vector<bool>& used, const LossOf& loss_of)
      : graph_(graph), equations_(graph, used, loss_of), cost_(equations_.cost()) {}

  MinimizerSummary run(const MinimizerSettings& settings) {
    MinimizerSummary summary;
    summary.initial_cost = cost_;
    equations_.linearise();
    bool can_continue = refactorize();
    while (can_continue && !summary.usable && summary.iterations < settings.max_iterations) {
      ++summary.iterations;
      if (!apply_step()) {
        summary.usable = cost_increase_ < kCostRounding * cost_;
        can_continue = !summary.usable && !factor_is_current_ && refactorize();
        continue;
      }
      equations_.linearise();
      factor_is_current_ = false;
      step_ = equations_.step();
      const double expected = equations_.expected_gain(step_);
      summary.usable = expected < settings.tolerance * cost_;
      if (summary.usable) {
        apply_step();  // the state is already near the minimum
      } else if (expected > kRefactorizeGain * cost_) {
        can_continue = refactorize();
      }
    }
    summary.final_cost = cost_;
    summary.message = summary.usable ? "converged" : failure(can_continue);
    return summary;
  }

 private:
  std::string failure(bool can_continue) const {
    if (can_continue) return "the iterations ran out";
    return is_singular_ ? "the equations are singular" : "a step did not lower the cost";
  }

  /// Factorises the current equations and solves them.
  bool refactorize() {
    factor_is_current_ = true;
    is_singular_ = !equations_.factorize();
    if (is_singular_) return false;
    step_ = equations_.step();
    is_singular_ = !step_.allFinite();
    return !is_singular_;
  }

  /// Applies the step. Returns false and restores the states if the cost does not decrease.
  bool apply_step() {
    std::vector<StateBlock> states = states_after(graph_, equations_, step_);
    graph_.states.swap(states);
    const double cost = equations_.cost();
    if (cost <= cost_) {
      cost_ = cost;
      return true;
    }
    cost_increase_ = std::isfinite(cost) ? cost - cost_ : std::numeric_limits<double>::infinity();
    graph_.states.swap(states);
    return false;
  }

  FactorGraph& graph_;
  NormalEquations<size> equations_;
  Eigen::VectorXd step_;
  double cost_;
  double cost_increase_ = 0.0;      ///< increase of the cost by the last rejected step
  bool factor_is_current_ = false;  ///< the factor belongs to the current states
  bool is_singular_ = false;        ///< the last equations had no finite solution
};

}  // namespace

MinimizerSummary gauss_newton(FactorGraph& graph, const std::vector<bool>& used,
                              const LossOf& loss_of, const MinimizerSettings& settings) {
  return graph.planar ? GaussNewtonSolver<3>(graph, used, loss_of).run(settings)
                      : GaussNewtonSolver<6>(graph, used, loss_of).run(settings);
}

}  // namespace lidar_mapping::pose_graph
