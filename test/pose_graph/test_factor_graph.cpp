// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pose_graph/factor_graph.hpp"
#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "error_text.hpp"
#include "solvers/gauss_newton.hpp"

namespace lidar_mapping::pose_graph {
namespace {

/// A residual of any number of rows: row i measures coordinate i mod 3 of the state as `measured[i
/// mod 3]`.
class Rows : public ceres::CostFunction {
 public:
  Rows(int rows, int block, const Eigen::Vector3d& measured) : measured_(measured) {
    set_num_residuals(rows);
    mutable_parameter_block_sizes()->push_back(block);
  }

  bool Evaluate(const double* const* states, double* residuals, double** jacobians) const override {
    const int block = parameter_block_sizes().front();
    for (int row = 0; row < num_residuals(); ++row) {
      residuals[row] = states[0][row % 3] - measured_[row % 3];
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      for (int column = 0; column < block; ++column) {
        jacobians[0][row * block + column] = column == row % 3 ? 1.0 : 0.0;
      }
    }
    return true;
  }

 private:
  Eigen::Vector3d measured_;
};

Constraint rows(int count, int block, const Eigen::Vector3d& measured = {1.0, 2.0, 0.5}) {
  Constraint constraint;
  constraint.residual = std::make_unique<Rows>(count, block, measured);
  return constraint;
}

class RowCount : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(OneToSix, RowCount, testing::Range(1, kMaxResidualRows + 1));

TEST_P(RowCount, AllNumbersOfRowsReachTheMinimum) {
  FactorGraph graph;
  graph.planar = true;
  graph.add_node(Pose());
  const Eigen::Vector3d first_measurement(1.0, 2.0, 0.5);
  const Eigen::Vector3d second_measurement(4.0, 3.0, 0.6);
  graph.add(rows(GetParam(), kPlanarBlockSize, first_measurement));
  graph.add(rows(3, kPlanarBlockSize, second_measurement));
  const LossOf none = [](const Constraint&) { return nullptr; };
  const MinimizerSummary summary = gauss_newton(graph, std::vector<bool>(2, true), none, {});
  EXPECT_TRUE(summary.usable) << summary.message;
  for (int i = 0; i < 3; ++i) {
    // Number of rows of the first constraint that measure coordinate i.
    const double count = (GetParam() + 2 - i) / 3;
    const double mean = (count * first_measurement[i] + second_measurement[i]) / (count + 1.0);
    EXPECT_NEAR(graph.states[0][i], mean, 1e-9);
  }
}

TEST_P(RowCount, AllRowsAreLinearised) {
  FactorGraph graph;
  graph.add_node(Pose());
  graph.add(rows(GetParam(), kPoseBlockSize));
  const LinearisedConstraint linear = linearise(graph, graph.constraints.front());
  ASSERT_EQ(linear.residual.size(), GetParam());
  EXPECT_EQ(linear.first.rows(), GetParam());
  EXPECT_DOUBLE_EQ(linear.residual.squaredNorm(), chi2(graph, graph.constraints.front()));
  EXPECT_EQ(linear.first.sum(), GetParam());
  EXPECT_GT(chi2_limit(GetParam()), 6.0);
}

std::string refusal(FactorGraph& graph, Constraint constraint) {
  return test::error_text<InputError>([&] { graph.add(std::move(constraint)); });
}

TEST(FactorGraph, RefusesConstraintsThatItCannotSolve) {
  FactorGraph graph;
  graph.add_node(Pose());
  EXPECT_NE(refusal(graph, rows(7, kPoseBlockSize)).find("7 rows"), std::string::npos);
  EXPECT_NE(refusal(graph, rows(3, kPlanarBlockSize)).find("1 of 7 numbers"), std::string::npos);
  EXPECT_NE(refusal(graph, Constraint()).find("no residual"), std::string::npos);
  Constraint elsewhere = rows(3, kPoseBlockSize);
  elsewhere.first = 1;
  EXPECT_NE(refusal(graph, std::move(elsewhere)).find("add the nodes first"), std::string::npos);
  Constraint single = rows(3, kPoseBlockSize);
  single.second = 0;  // takes one parameter block, but is between two nodes
  EXPECT_NE(refusal(graph, std::move(single)).find("2 of 7 numbers"), std::string::npos);
  EXPECT_TRUE(graph.constraints.empty());
  EXPECT_THROW(chi2_limit(0), InputError);
  EXPECT_THROW(chi2_limit(7), InputError);
}

/// A residual x + x^3 of each coordinate of a planar state: no step leads to its minimum at once.
/// `evaluates` is what it says to who asks for it; Ceres gives up at false.
class Cubic : public ceres::SizedCostFunction<kPlanarBlockSize, kPlanarBlockSize> {
 public:
  explicit Cubic(bool evaluates) : evaluates_(evaluates) {}

  bool Evaluate(const double* const* states, double* residuals, double** jacobians) const override {
    for (int row = 0; row < kPlanarBlockSize; ++row) {
      const double x = states[0][row];
      residuals[row] = x + x * x * x;
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      for (int column = 0; column < kPlanarBlockSize; ++column) {
        jacobians[0][row * kPlanarBlockSize + column] = column == row ? 1.0 + 3.0 * x * x : 0.0;
      }
    }
    return evaluates_;
  }

 private:
  bool evaluates_;
};

FactorGraph cubic_graph(bool evaluates) {
  FactorGraph graph;
  graph.planar = true;
  graph.add_node({exp_so3({0.0, 0.0, 1.0}), {1.0, 1.0, 0.0}});
  Constraint constraint;
  constraint.residual = std::make_unique<Cubic>(evaluates);
  graph.add(std::move(constraint));
  return graph;
}

// Three coordinates with residuals of 2.
constexpr double kCubicCost = 12.0;

MinimizerSettings of_one_step() {
  MinimizerSettings settings;
  settings.max_iterations = 1;
  return settings;
}

const LossOf kNoLoss = [](const Constraint&) { return nullptr; };

TEST(Minimize, LeavesTheStatesIfBothSolversFail) {
  FactorGraph graph = cubic_graph(false);
  const std::vector<StateBlock> before = graph.states;
  const MinimizerSummary summary = minimize(graph, {true}, kNoLoss, of_one_step());
  EXPECT_FALSE(summary.usable);
  EXPECT_EQ(graph.states, before);
}

TEST(Minimize, ReportsTheCostOfItsStartIfTheSecondSolverContinues) {
  FactorGraph graph = cubic_graph(true);
  const MinimizerSummary summary = minimize(graph, {true}, kNoLoss, of_one_step());
  EXPECT_TRUE(summary.usable) << summary.message;
  EXPECT_NEAR(summary.initial_cost, kCubicCost, 1e-9);
  EXPECT_LT(summary.final_cost, 0.5 * kCubicCost);
}

TEST(GaussNewtonEnd, SaysThatTheIterationsRanOut) {
  FactorGraph graph = cubic_graph(true);
  const MinimizerSummary summary = gauss_newton(graph, {true}, kNoLoss, of_one_step());
  EXPECT_FALSE(summary.usable);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(summary.message, "the iterations ran out");
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
