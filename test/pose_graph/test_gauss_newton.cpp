// SPDX-License-Identifier: BSD-3-Clause
// The package's own solver against Ceres: both minimise the same cost by different code.

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include "lidar_mapping/pose_graph/factor_graph.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"

#include "near.hpp"
#include "solvers/gauss_newton.hpp"

namespace lidar_mapping::pose_graph {
namespace {

// Both solvers go on until another step gains less than this fraction of the cost.
constexpr double kTolerance = 1e-15;

/// Kinds of random graphs.
struct Kind {
  const char* name;
  bool planar;
  RobustKernel kernel;

  // The cost is flat at the minimum: where it agrees to rounding, the poses agree to micrometres.
  // With a kernel the steps shrink only by a factor from one to the next, and end a little earlier.
  double cost_tolerance() const { return kernel == RobustKernel::kNone ? 1e-11 : 1e-8; }
  double pose_tolerance() const { return kernel == RobustKernel::kNone ? 1e-5 : 1e-4; }
};

void PrintTo(const Kind& kind, std::ostream* stream) { *stream << kind.name; }

/// Draws a graph of key frames on a winding path: odometry, loops between any two of them, and in
/// 3D antenna positions, so that residuals of all sizes and with one and two nodes occur.
class RandomGraph {
 public:
  RandomGraph(const Kind& kind, int nodes, unsigned seed) : kind_(kind), engine_(seed) {
    graph_.planar = kind.planar;
    add_nodes(nodes);
    for (int i = 1; i < nodes; ++i) add_motion(i - 1, i, 1.0, RobustKernel::kNone);
    std::uniform_int_distribution<int> any(0, nodes - 1);
    for (int k = 0; k < nodes / 3; ++k) {
      const int from = any(engine_);
      const int to = any(engine_);
      // Every fourth loop errs by more than its covariance says.
      if (from != to) add_motion(from, to, k % 4 == 3 ? 6.0 : 1.0, kind_.kernel);
    }
    if (!kind.planar) add_positions();
    used_.assign(graph_.constraints.size(), true);
    add_unused();
  }

  MinimizerSummary solve_by_gauss_newton(FactorGraph& graph) const {
    return gauss_newton(graph, used_, losses(), settings());
  }
  MinimizerSummary solve_by_ceres(FactorGraph& graph) const {
    MinimizerSettings damped = settings();
    damped.initial_radius = 1e4;
    return minimize(graph, used_, losses(), damped);
  }
  FactorGraph& graph() { return graph_; }
  /// Of the current states, without kernels.
  double cost() const { return total_chi2(graph_, used_); }
  /// Moves all nodes but the fixed one.
  void scatter(double metres, double radians) {
    for (int i = 1; i < static_cast<int>(truth_.size()); ++i) {
      graph_.set_pose(i, perturbed(graph_.pose(i), noise(metres, radians)));
    }
  }

 private:
  static MinimizerSettings settings() {
    MinimizerSettings settings;
    settings.max_iterations = 300;
    settings.tolerance = kTolerance;
    return settings;
  }

  Vector6d noise(double metres, double radians) {
    std::normal_distribution<double> normal;
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = normal(engine_) * (i < 3 ? metres : radians);
    if (kind_.planar) d.segment<3>(2).setZero();
    return d;
  }

  void add_nodes(int count) {
    Pose pose;
    for (int i = 0; i < count; ++i) {
      truth_.push_back(pose);
      graph_.add_node(i == 0 ? pose : perturbed(pose, noise(0.2, 0.02)), i == 0);
      Vector6d step = noise(0.1, 0.1);
      step[0] += 1.0;
      pose = perturbed(pose, step);
    }
  }

  void add_motion(int from, int to, double error, RobustKernel kernel) {
    const Pose motion = truth_[from].inverse() * truth_[to];
    const Pose measured = perturbed(motion, Vector6d(error * noise(0.05, 0.01)));
    Constraint constraint;
    constraint.first = from;
    constraint.second = to;
    constraint.kernel = kernel;
    constraint.kernel_size = 2.0;
    if (kind_.planar) {
      const Eigen::Vector3d information(1.0 / 0.0025, 1.0 / 0.0025, 1.0 / 0.0001);
      constraint.residual = planar_relative_pose_residual(
          {measured.translation.x(), measured.translation.y(), yaw_of(measured.rotation)},
          information.asDiagonal());
    } else {
      constraint.residual =
          relative_pose_residual(measured, g2o_information(diagonal_covariance(0.05, 0.01)));
    }
    graph_.add(std::move(constraint));
  }

  void add_positions() {
    const Eigen::Vector3d arm(0.5, 0.2, 1.5);
    for (std::size_t i = 0; i < truth_.size(); i += 5) {
      const Eigen::Vector3d p = truth_[i] * arm + noise(0.3, 0.0).head<3>();
      Constraint horizontal;
      horizontal.first = static_cast<int>(i);
      horizontal.residual = antenna_horizontal_residual(p, arm, 0.09 * Eigen::Matrix2d::Identity());
      graph_.add(std::move(horizontal));
      Constraint altitude;
      altitude.first = static_cast<int>(i);
      altitude.residual = antenna_altitude_residual(p.z(), arm, 0.3);
      graph_.add(std::move(altitude));
    }
  }

  /// A gross error that no solver may look at.
  void add_unused() {
    add_motion(0, static_cast<int>(truth_.size()) - 1, 1000.0, RobustKernel::kNone);
    used_.push_back(false);
  }

  LossOf losses() const {
    return [this](const Constraint& constraint) -> ceres::LossFunction* {
      if (constraint.kernel == RobustKernel::kNone) return nullptr;
      if (!loss_) loss_ = make_kernel(constraint.kernel, constraint.kernel_size);
      return loss_.get();
    };
  }

  Kind kind_;
  std::mt19937 engine_;
  std::vector<Pose> truth_;
  FactorGraph graph_;
  std::vector<bool> used_;
  mutable std::unique_ptr<ceres::LossFunction> loss_;
};

class GaussNewton : public testing::TestWithParam<Kind> {};

TEST_P(GaussNewton, ReachesTheMinimumOfCeres) {
  for (const int nodes : {20, 70, 150, 300}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      SCOPED_TRACE(std::to_string(nodes) + " nodes, seed " + std::to_string(seed));
      RandomGraph random(GetParam(), nodes, seed);
      FactorGraph& graph = random.graph();
      const std::vector<StateBlock> start = graph.states;
      const MinimizerSummary by_ceres = random.solve_by_ceres(graph);
      std::vector<Pose> expected;
      for (int i = 0; i < nodes; ++i) expected.push_back(graph.pose(i));
      graph.states = start;
      const MinimizerSummary found = random.solve_by_gauss_newton(graph);

      ASSERT_TRUE(by_ceres.usable) << by_ceres.message;
      ASSERT_TRUE(found.usable) << found.message;
      EXPECT_NEAR(found.initial_cost, by_ceres.initial_cost, 1e-12 * by_ceres.initial_cost);
      EXPECT_LT(found.final_cost, 0.5 * found.initial_cost) << "the start must not be the minimum";
      EXPECT_NEAR(found.final_cost, by_ceres.final_cost,
                  GetParam().cost_tolerance() * by_ceres.final_cost);
      for (int i = 0; i < nodes; ++i) {
        ASSERT_TRUE(test::near(graph.pose(i), expected[i], GetParam().pose_tolerance())) << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Graphs, GaussNewton,
                         testing::Values(Kind{"LeastSquares", false, RobustKernel::kNone},
                                         Kind{"Huber", false, RobustKernel::kHuber},
                                         Kind{"PseudoHuber", false, RobustKernel::kPseudoHuber},
                                         Kind{"Cauchy", false, RobustKernel::kCauchy},
                                         Kind{"PlanarLeastSquares", true, RobustKernel::kNone},
                                         Kind{"PlanarHuber", true, RobustKernel::kHuber},
                                         Kind{"PlanarCauchy", true, RobustKernel::kCauchy}),
                         [](const auto& graph) { return std::string(graph.param.name); });

TEST(GaussNewtonSolver, LeavesFixedAndUnconstrainedNodesWhereTheyAre) {
  RandomGraph random(Kind{"LeastSquares", false, RobustKernel::kNone}, 30, 5);
  FactorGraph& graph = random.graph();
  graph.fixed[12] = true;
  const Pose alone{exp_so3({0.1, 0.2, 0.3}), {100.0, 5.0, -3.0}};
  const int unconstrained = graph.add_node(alone);
  const std::vector<StateBlock> start = graph.states;
  ASSERT_TRUE(random.solve_by_gauss_newton(graph).usable);
  for (const int node : {0, 12, unconstrained}) {
    EXPECT_EQ(graph.states[node], start[node]) << node;
  }
  const std::vector<StateBlock> found = graph.states;
  graph.states = start;
  ASSERT_TRUE(random.solve_by_ceres(graph).usable);
  for (int i = 0; i < 30; ++i) {
    EXPECT_TRUE(test::near(to_pose(found[i].data()), graph.pose(i), 1e-5)) << i;
  }
}

TEST(GaussNewtonSolver, NeverRaisesTheCost) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
    SCOPED_TRACE(seed);
    RandomGraph random(Kind{"LeastSquares", false, RobustKernel::kNone}, 40, seed);
    // From here the linearised cost is wrong: a step may overshoot.
    random.scatter(20.0, 1.5);
    const MinimizerSummary summary = random.solve_by_gauss_newton(random.graph());
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    if (!summary.usable) {
      EXPECT_EQ(summary.message, "a step did not lower the cost");
    }
    const double cost = random.cost();
    EXPECT_NEAR(cost, summary.final_cost, 1e-12 * cost) << "of the states that are left";
  }
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
