// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/pose_graph/block_cholesky.hpp"
#include "lidar_mapping/pose_graph/graph_optimizer.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"

#include "initialization/chordal_initialization.hpp"
#include "initialization/odometry_chain.hpp"
#include "near.hpp"
#include "synthetic_drive.hpp"

namespace lidar_mapping::pose_graph {
namespace {

/// Two laps with a loop at every tenth key frame of the second one; the file has the poses of
/// odometry.
PoseGraph lap_graph(bool planar, const test::SyntheticDrive& drive, int lap = 400) {
  std::mt19937 engine(3);
  PoseGraph graph;
  graph.planar = planar;
  const auto chordal_edge = [&](Pose pose) {
    if (!planar) return pose;
    pose.translation.z() = 0.0;
    pose.rotation = exp_so3({0.0, 0.0, yaw_of(pose.rotation)});
    return pose;
  };
  const Matrix6d odometry = g2o_information(diagonal_covariance(0.02, 0.001));
  const Matrix6d loop = g2o_information(diagonal_covariance(0.05, 0.003));
  const int count = static_cast<int>(drive.key_frames.size());
  for (int i = 0; i < count; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    graph.nodes.push_back({i, chordal_edge(drive.key_frames[slot].T_odom_base)});
    if (i == 0) continue;
    graph.edges.push_back({i - 1, i,
                           chordal_edge(drive.key_frames[slot - 1].T_odom_base.inverse() *
                                        drive.key_frames[slot].T_odom_base),
                           odometry});
  }
  for (int i = lap; i < count; i += 10) {
    graph.edges.push_back(
        {i - lap, i,
         chordal_edge(test::make_loop(drive, i - lap, i, engine, 0.05, 0.003).T_from_to), loop});
  }
  return graph;
}

double largest_shift(const PoseGraph& a, const PoseGraph& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    const double shift = (a.nodes[i].pose.translation - b.nodes[i].pose.translation).norm();
    largest = std::max(largest, shift);
  }
  return largest;
}

class BothKinds : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlanarOrNot, BothKinds, testing::Bool());

TEST_P(BothKinds, LeastSquaresDoesNotDependOnThePosesOfTheFile) {
  PoseGraph graph = lap_graph(GetParam(), test::make_drive());
  PoseGraph scattered = graph;
  std::mt19937 engine(9);
  for (std::size_t i = 1; i < scattered.nodes.size(); ++i) {
    Vector6d d = test::noise(engine, 50.0, 1.0);
    if (GetParam()) d.segment<3>(2).setZero();
    scattered.nodes[i].pose = perturbed(scattered.nodes[i].pose, d);
  }
  const GraphReport a = optimize(graph);
  const GraphReport b = optimize(scattered);
  EXPECT_TRUE(a.success);
  EXPECT_EQ(a.start, "chordal");
  EXPECT_LE(a.iterations, 4);
  EXPECT_NEAR(a.final_cost, b.final_cost, 1e-6 * a.final_cost);
  EXPECT_LT(largest_shift(graph, scattered), 1e-3);
}

TEST_P(BothKinds, ChordalInitializationIsExactForExactMeasurements) {
  test::DriveSettings settings;
  settings.odometry_stddev_m = settings.odometry_stddev_deg = 1e-12;
  settings.scale_error = settings.turn_bias_deg = 0.0;
  PoseGraph graph = lap_graph(GetParam(), test::make_drive(settings));
  graph.edges.resize(graph.nodes.size() - 1);
  PoseGraph started = graph;
  for (PoseNode& node : started.nodes) node.pose = graph.nodes.front().pose;
  ASSERT_TRUE(initialize_chordally(started));
  EXPECT_LT(largest_shift(graph, started), 1e-6);
}

// The equations of the second half are singular, but for the rounding of their weights.
TEST_P(BothKinds, AnUnconnectedGraphStartsFromThePosesOfTheFile) {
  PoseGraph graph = lap_graph(GetParam(), test::make_drive());
  graph.edges.resize(graph.nodes.size() - 1);
  graph.edges.erase(graph.edges.begin() + 400);
  PoseGraph started = graph;
  EXPECT_FALSE(initialize_chordally(started));
  EXPECT_EQ(largest_shift(graph, started), 0.0);
  EXPECT_EQ(optimize(graph).start, "file");
}

TEST_P(BothKinds, FalseLoopsAreRefusedAndTrueOnesUsed) {
  const test::SyntheticDrive drive = test::make_drive();
  PoseGraph clean = lap_graph(GetParam(), drive);
  PoseGraph spoiled = clean;
  const std::size_t true_edges = clean.edges.size();
  std::mt19937 engine(4);
  std::uniform_int_distribution<int> pick(0, 150);
  // Consistent groups of false loops between two locations, as many as true loops.
  for (int group = 0; group < 4; ++group) {
    const int from = pick(engine);
    const int to = from + 200 + 30 * group;
    for (int k = 0; k < 10; ++k) {
      PoseEdge edge = clean.edges.back();
      edge.from = from + k;
      edge.to = to + k;
      edge.T_from_to = Pose();
      spoiled.edges.push_back(edge);
    }
  }
  GraphOptions options;
  options.graduated = true;
  const GraphReport report = optimize(spoiled, options);
  optimize(clean);
  std::size_t refused_true = 0;
  for (const std::size_t i : report.refused) refused_true += i < true_edges ? 1 : 0;
  EXPECT_EQ(report.refused.size() - refused_true, 40U);
  EXPECT_LE(refused_true, 1U);
  EXPECT_LT(largest_shift(clean, spoiled), 0.05);
}

TEST(GraphOptimizer, ClosesALoopOfFourKeyFrames) {
  PoseGraph graph;
  const Pose quarter = {exp_so3({0.0, 0.0, M_PI / 2.0}), {1.0, 0.0, 0.0}};
  for (int i = 0; i < 4; ++i) graph.nodes.push_back({i, Pose()});
  for (int i = 0; i < 4; ++i) {
    graph.edges.push_back({i, (i + 1) % 4, quarter, Matrix6d::Identity()});
  }
  EXPECT_LT(optimize(graph).final_cost, 1e-9);
  EXPECT_TRUE(test::near(graph.nodes[2].pose.translation, Eigen::Vector3d(1.0, 1.0, 0.0), 1e-5));
}

TEST(GraphOptimizer, ASolvedGraphDoesNotMove) {
  PoseGraph graph = lap_graph(false, test::make_drive());
  optimize(graph);
  PoseGraph solved_again = graph;
  optimize(solved_again);
  EXPECT_LT(largest_shift(graph, solved_again), 1e-4);
}

TEST(BlockCholesky, AgreesWithADenseSolver) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  const std::vector<std::pair<int, int>> pairs = {{0, 1}, {2, 1}, {3, 2}, {0, 3}, {4, 0}, {1, 0}};
  BlockCholesky<3> sparse(5, pairs);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(15, 15);
  for (int round = 0; round < 2; ++round) {  // the second round reuses the analysis
    sparse.set_zero();
    dense.setZero();
    for (int i = 0; i < 5; ++i) {
      sparse.add_diagonal(i, 20.0 * Eigen::Matrix3d::Identity());
      dense.block<3, 3>(3 * i, 3 * i) += 20.0 * Eigen::Matrix3d::Identity();
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Eigen::Matrix3d block = Eigen::Matrix3d::NullaryExpr([&] { return normal(engine); });
      sparse.add_pair(k, block);
      dense.block<3, 3>(3 * pairs[k].first, 3 * pairs[k].second) += block;
      dense.block<3, 3>(3 * pairs[k].second, 3 * pairs[k].first) += block.transpose();
    }
    const Eigen::MatrixXd rhs = Eigen::MatrixXd::NullaryExpr(15, 2, [&] { return normal(engine); });
    ASSERT_TRUE(sparse.factorize());
    EXPECT_TRUE(test::near(dense * sparse.solve(rhs), rhs, 1e-10));
  }
}

std::ptrdiff_t threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"),
                       std::filesystem::directory_iterator());
}

// OpenMP threads that wait actively between the parts of a factorisation cost a third more
// processor time.
TEST(Solving, StartsNoThreads) {
  const test::SyntheticDrive drive = test::make_drive({1});
  PoseGraph graph = lap_graph(false, drive);
  std::mt19937 engine(3);
  const int count = static_cast<int>(graph.nodes.size());
  for (int i = 0; i < count; ++i) {
    // Distributed over the graph, so that the factor is dense.
    const int other = (i * 37 + 11) % count;
    if (std::abs(i - other) < 2) continue;
    const Pose T = test::make_loop(drive, i, other, engine).T_from_to;
    graph.edges.push_back({i, other, T, Matrix6d::Identity()});
  }
  const std::ptrdiff_t before = threads_of_this_process();
  EXPECT_TRUE(optimize(graph, {}).success);
  EXPECT_LE(threads_of_this_process(), before);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
