// SPDX-License-Identifier: BSD-3-Clause
// Constraints at the current states, and which of them a robust solution uses.

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/pose_graph/linearisation.hpp"
#include "lidar_mapping/pose_graph/robust_solver.hpp"

namespace lidar_mapping::pose_graph {
namespace {

Pose at_x(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

/// Node `second` is measured `metres` ahead of node `first`, with the standard deviation `sigma`.
Constraint ahead(int first, int second, double metres, double sigma) {
  Constraint constraint;
  constraint.residual =
      relative_pose_residual(at_x(metres), Matrix6d::Identity() / (sigma * sigma));
  constraint.first = first;
  constraint.second = second;
  return constraint;
}

Constraint loop(int first, int second, double metres, double sigma) {
  Constraint constraint = ahead(first, second, metres, sigma);
  constraint.switchable = true;
  return constraint;
}

Constraint prior(int node, double x, double sigma) {
  Constraint constraint;
  constraint.residual = prior_residual(at_x(x), Matrix6d::Identity() / (sigma * sigma));
  constraint.first = node;
  return constraint;
}

constexpr double kOdometrySigma = 0.02, kLoopSigma = 0.01;  // m

/// Nodes in a row, a metre apart by odometry that measures each step as `step` metres; the states
/// follow the odometry, the first one is fixed.
FactorGraph chain(int nodes, double step) {
  FactorGraph graph;
  for (int i = 0; i < nodes; ++i) graph.add_node(at_x(step * i), i == 0);
  for (int i = 1; i < nodes; ++i) graph.add(ahead(i - 1, i, step, kOdometrySigma));
  return graph;
}

double x_of(const FactorGraph& graph, int node) { return graph.pose(node).translation.x(); }

double weight(RobustKernel kernel, double size, double residual) {
  Constraint constraint = prior(0, 0.0, 1.0);
  constraint.kernel = kernel;
  constraint.kernel_size = size;
  return kernel_weight(constraint, Eigen::VectorXd::Constant(1, residual));
}

TEST(KernelWeight, IsTheSlopeOfTheLoss) {
  EXPECT_EQ(weight(RobustKernel::kNone, 1.0, 100.0), 1.0);
  EXPECT_DOUBLE_EQ(weight(RobustKernel::kHuber, 2.0, 1.5), 1.0);
  EXPECT_DOUBLE_EQ(weight(RobustKernel::kHuber, 2.0, -8.0), 0.25);
  EXPECT_DOUBLE_EQ(weight(RobustKernel::kCauchy, 2.0, 4.0), 0.2);
  EXPECT_DOUBLE_EQ(weight(RobustKernel::kGemanMcClure, 1.0, 1.0), 0.25);
  EXPECT_EQ(weight(RobustKernel::kSaturated, 2.0, 2.1), 0.0);
}

TEST(Linearise, HasNoSecondDerivativeForOneNode) {
  FactorGraph graph;
  graph.add_node(at_x(3.0));
  const Constraint constraint = prior(0, 1.0, 0.5);
  const LinearisedConstraint linearised = linearise(graph, constraint);
  ASSERT_EQ(linearised.residual.size(), 6);
  EXPECT_NEAR(linearised.residual.norm(), 4.0, 1e-12);
  EXPECT_NEAR(std::abs(linearised.first(0, 0)), 2.0, 1e-12);
  EXPECT_EQ(linearised.second.norm(), 0.0);
}

/// Variance of the position of the last node along x.
double variance_at_end(const FactorGraph& graph, const std::vector<bool>& selected) {
  const auto system = information_matrix(graph, selected);
  if (!system->factorize()) return -1.0;
  const auto size = 6 * static_cast<Eigen::Index>(graph.states.size());
  return system->solve(Eigen::VectorXd::Unit(size, size - 6))(size - 6, 0);
}

// Variances of a chain add up; those of independent ways to a node are combined by their inverses.
TEST(InformationMatrix, AddsTheInformationOfTheSelectedConstraints) {
  FactorGraph graph;
  for (int i = 0; i < 3; ++i) graph.add_node(at_x(i));
  graph.add(prior(0, 0.0, 0.1));
  graph.add(ahead(0, 1, 1.0, 0.2));
  graph.add(ahead(1, 2, 1.0, 0.2));
  graph.add(ahead(0, 2, 2.0, 0.3));
  const double by_chain = 0.04 + 0.04, by_loop = 0.09;
  EXPECT_NEAR(variance_at_end(graph, {true, true, true, false}), 0.01 + by_chain, 1e-9);
  EXPECT_NEAR(variance_at_end(graph, {true, true, true, true}),
              0.01 + by_chain * by_loop / (by_chain + by_loop), 1e-9);
}

TEST(InformationMatrix, WeighsOnlyDoubtfulConstraintsByTheirKernels) {
  for (const bool doubtful : {false, true}) {
    FactorGraph graph;
    graph.add_node(at_x(0.0));
    graph.add_node(at_x(1.0));
    graph.add(prior(0, 0.0, 0.1));
    Constraint step = ahead(0, 1, 1.6, 0.2);  // off by three standard deviations
    step.kernel = RobustKernel::kCauchy;
    step.doubtful = doubtful;
    graph.add(std::move(step));
    const double expected = 0.01 + (doubtful ? 0.04 * (1.0 + 9.0) : 0.04);
    EXPECT_NEAR(variance_at_end(graph, {true, true}), expected, 1e-9) << doubtful;
  }
}

// Twice the quantile of 99 % for six rows is 33.624, of a residual of 5.7986 standard deviations.
TEST(ConsistentConstraints, AreBelowTwiceTheLimitOrNotSwitchable) {
  FactorGraph graph;
  graph.add_node(at_x(0.0));
  graph.add_node(at_x(1.0));
  graph.add(loop(0, 1, 1.0 + 5.79, 1.0));
  graph.add(loop(0, 1, 1.0 + 5.81, 1.0));
  graph.add(loop(0, 1, 1.0 - 5.81, 1.0));
  graph.add(ahead(0, 1, 100.0, 1.0));
  EXPECT_EQ(consistent_constraints(graph), (std::vector<bool>{true, false, false, true}));
}

TEST(SolveSelected, TakesTheWeightedMeanOfWhatItUses) {
  FactorGraph graph;
  graph.add_node(at_x(0.0));
  graph.add(prior(0, 0.0, 1.0));
  graph.add(prior(0, 3.0, std::sqrt(0.5)));
  graph.add(prior(0, 90.0, 0.1));
  const RobustSolution solution = solve_selected(graph, {true, true, false});
  EXPECT_TRUE(solution.success) << solution.message;
  EXPECT_NEAR(x_of(graph, 0), 2.0, 1e-6);
  EXPECT_NEAR(solution.cost_before, 18.0, 1e-9);
  EXPECT_NEAR(solution.cost_after, 4.0 + 2.0, 1e-6);
  EXPECT_EQ(solution.used, (std::vector<bool>{true, true, false}));
  EXPECT_GT(solution.iterations, 0);
}

// Four steps err by 2 cm each. The loop takes over the error but for its share of the variance,
// 1 : 17; a second loop is off by 10 m.
TEST(SolveGraduated, UsesTheTrueLoopAndRefusesTheFalseOne) {
  FactorGraph graph = chain(5, 1.02);
  graph.add(loop(0, 4, 4.0, kLoopSigma));
  graph.add(loop(1, 4, 13.0, kLoopSigma));
  const RobustSolution solution = solve_graduated(graph);
  EXPECT_TRUE(solution.success) << solution.message;
  EXPECT_EQ(solution.used, (std::vector<bool>{true, true, true, true, true, false}));
  EXPECT_NEAR(x_of(graph, 4), 4.0 + 0.08 / 17.0, 1e-5);
  EXPECT_NEAR(x_of(graph, 0), 0.0, 1e-12) << "it is fixed";
  EXPECT_NEAR(solution.cost_before, 64.0, 1e-6) << "of what is used, at the start";
  EXPECT_NEAR(solution.cost_after, 0.08 * 0.08 / (4.0 * 0.0004 + 0.0001), 1e-4);
}

TEST(SolveGraduated, LeavesAChainWithoutLoopsAsItIs) {
  FactorGraph graph = chain(4, 1.02);
  const RobustSolution solution = solve_graduated(graph);
  EXPECT_TRUE(solution.success) << solution.message;
  EXPECT_EQ(solution.used, std::vector<bool>(3, true));
  EXPECT_NEAR(x_of(graph, 3), 3.06, 1e-9);
}

// One step was matched wrongly, by a metre, and says that it may be.
TEST(SolveGraduated, TakesADoubtfulStepForNoEvidenceAgainstLoops) {
  FactorGraph graph = chain(5, 1.0);
  Constraint wrong = ahead(1, 2, 2.0, kOdometrySigma);
  wrong.doubtful = true;
  wrong.kernel = RobustKernel::kCauchy;
  graph.constraints[1] = std::move(wrong);
  for (int node = 2; node < 5; ++node) graph.set_pose(node, at_x(node + 1.0));
  graph.add(loop(0, 3, 3.0, kLoopSigma));
  graph.add(loop(0, 4, 4.0, kLoopSigma));
  const RobustSolution solution = solve_graduated(graph);
  EXPECT_TRUE(solution.success) << solution.message;
  EXPECT_EQ(solution.used, std::vector<bool>(6, true));
  EXPECT_NEAR(x_of(graph, 1), 1.0, 0.01);
  EXPECT_NEAR(x_of(graph, 4), 4.0, 0.01);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
