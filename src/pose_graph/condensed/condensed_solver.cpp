// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/condensed_solver.hpp"

#include <array>

#include "condensed/condensed_minimizer.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// The used constraints of a factor graph.
template <int size>
class FactorGraphProblem : public CondensedProblem<size> {
 public:
  FactorGraphProblem(FactorGraph& graph, const std::vector<bool>& used, const LossOf& loss_of)
      : graph_(graph) {
    for (std::size_t i = 0; i < graph.constraints.size(); ++i) {
      if (used[i]) terms_.push_back({&graph.constraints[i], loss_of(graph.constraints[i])});
    }
  }

  int node_count() const override { return static_cast<int>(graph_.states.size()); }
  int factor_count() const override { return static_cast<int>(terms_.size()); }
  std::pair<int, int> nodes_of(int factor) const override {
    const Constraint& constraint = *terms_[factor].constraint;
    return {constraint.first, constraint.second};
  }
  bool is_fixed(int node) const override { return graph_.fixed[node]; }

  double cost(int factor) const override {
    const Term& term = terms_[factor];
    return loss_at(term.loss, chi2(graph_, *term.constraint)).first;
  }

  void linearise(int factor, FactorBlocks<size>& blocks) const override {
    // Columns of a Jacobian per node, by the layout of Ceres: one per number of the state.
    constexpr int kBlock = size == 6 ? kPoseBlockSize : kPlanarBlockSize;
    using Jacobian =
        Eigen::Matrix<double, Eigen::Dynamic, kBlock, Eigen::RowMajor, kMaxResidualRows, kBlock>;
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, size, 0, kMaxResidualRows, size>;
    const Term& term = terms_[factor];
    const Constraint& constraint = *term.constraint;
    const int rows = constraint.degrees_of_freedom();
    std::array<Jacobian, 2> jacobians = {Jacobian(rows, kBlock), Jacobian(rows, kBlock)};
    std::array<double, kMaxResidualRows> values{};
    std::array<double*, 2> targets = {jacobians[0].data(), jacobians[1].data()};
    evaluate(graph_, constraint, values.data(), targets.data());
    const Eigen::Map<const Eigen::VectorXd> residual(values.data(), rows);
    const double weight = loss_at(term.loss, residual.squaredNorm()).second;
    const Rows first = jacobians[0].template leftCols<size>();
    blocks.first.noalias() = weight * first.transpose() * first;
    blocks.first_gradient.noalias() = weight * first.transpose() * residual;
    if (!constraint.is_binary()) return;
    const Rows second = jacobians[1].template leftCols<size>();
    blocks.second.noalias() = weight * second.transpose() * second;
    blocks.second_gradient.noalias() = weight * second.transpose() * residual;
    blocks.cross.noalias() = weight * first.transpose() * second;
  }

  void apply(const std::vector<int>& nodes, const Eigen::VectorXd& step) override {
    before_ = graph_.states;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double* d = step.data() + static_cast<std::ptrdiff_t>(size * i);
      StateBlock& block = graph_.states[nodes[i]];
      if (size == 6) {
        block = retract(block.data(), d);
      } else {
        for (std::size_t k = 0; k < static_cast<std::size_t>(size); ++k) block[k] += d[k];
      }
    }
  }

  void restore() override { graph_.states = before_; }

 private:
  struct Term {
    const Constraint* constraint;
    ceres::LossFunction* loss;
  };

  FactorGraph& graph_;
  std::vector<Term> terms_;
  std::vector<StateBlock> before_;  ///< states before the last step
};

template <int size>
MinimizerSummary minimize_graph(FactorGraph& graph, const std::vector<bool>& used,
                                const LossOf& loss_of, const MinimizerSettings& settings,
                                int threads) {
  FactorGraphProblem<size> problem(graph, used, loss_of);
  return minimize_condensed<size>(problem, condensed_structure<size>(problem, threads), settings,
                                  threads);
}

}  // namespace

MinimizerSummary minimize_condensed(FactorGraph& graph, const std::vector<bool>& used,
                                    const LossOf& loss_of, const MinimizerSettings& settings,
                                    int threads) {
  const std::vector<StateBlock> before = graph.states;
  const MinimizerSummary summary = graph.planar
                                       ? minimize_graph<3>(graph, used, loss_of, settings, threads)
                                       : minimize_graph<6>(graph, used, loss_of, settings, threads);
  if (!summary.usable) graph.states = before;
  return summary;
}

}  // namespace lidar_mapping::pose_graph
