// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include "lidar_mapping/pose_graph/condensed_solver.hpp"
#include "lidar_mapping/pose_graph/graph_optimizer.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"

#include "initialization/coarse_initialization.hpp"
#include "near.hpp"
#include "street_graph.hpp"

namespace lidar_mapping::pose_graph {
namespace {

PoseGraph streets(int key_frames, int loops, unsigned seed = 1) {
  test::StreetSettings settings;
  settings.key_frames = key_frames;
  settings.loops = loops;
  settings.seed = seed;
  return test::make_street_graph(settings).graph;
}

/// A drive without a place that it sees twice.
PoseGraph open_chain() { return streets(1500, 0); }

/// Nearly every key frame has a loop to one of the last ten.
PoseGraph short_loops() {
  PoseGraph graph = streets(300, 0);
  std::mt19937 engine(2);
  const Matrix6d information = test::information_of(0.05, 0.2);
  for (int i = 10; i < 300; ++i) {
    const int from = i - 2 - static_cast<int>(engine() % 8);
    const Pose motion = graph.nodes[from].pose.inverse() * graph.nodes[i].pose;
    graph.edges.push_back({from, i, test::measured(motion, engine, 0.05, 0.2), information});
  }
  return graph;
}

/// Loops between any two key frames, so that hardly anything can be eliminated cheaply; some of
/// them are given twice, and some lead backwards.
PoseGraph long_loops() {
  const test::StreetGraph drive = [] {
    test::StreetSettings settings;
    settings.key_frames = 1200;
    settings.loops = 0;
    return test::make_street_graph(settings);
  }();
  PoseGraph graph = drive.graph;
  std::mt19937 engine(3);
  for (int k = 0; k < 150; ++k) {
    const auto a = static_cast<std::size_t>(engine() % 1200);
    const auto b = static_cast<std::size_t>(engine() % 1200);
    if (a == b) continue;
    const Pose motion = drive.truth[a].inverse() * drive.truth[b];
    for (int copy = 0; copy <= k % 2; ++copy) {
      graph.edges.push_back({static_cast<std::int64_t>(a), static_cast<std::int64_t>(b),
                             test::measured(motion, engine, 0.1, 0.3),
                             test::information_of(0.1, 0.3)});
    }
  }
  return graph;
}

/// Several drives, whose odometry is not connected; ids have gaps between them.
PoseGraph several_drives() {
  PoseGraph graph = streets(2400, 800, 4);
  const auto id_of = [](std::int64_t id) { return id + 1000 * (id / 400); };
  graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(),
                                   [](const PoseEdge& edge) {
                                     return edge.to % 400 == 0 && edge.to - edge.from == 1;
                                   }),
                    graph.edges.end());
  for (PoseNode& node : graph.nodes) node.id = id_of(node.id);
  for (PoseEdge& edge : graph.edges) {
    edge.from = id_of(edge.from);
    edge.to = id_of(edge.to);
  }
  return graph;
}

PoseGraph town() { return streets(3000, 800); }

Pose flattened(const Pose& pose) {
  return {exp_so3({0.0, 0.0, yaw_of(pose.rotation)}),
          {pose.translation.x(), pose.translation.y(), 0.0}};
}

PoseGraph flattened(PoseGraph graph) {
  graph.planar = true;
  for (PoseNode& node : graph.nodes) node.pose = flattened(node.pose);
  for (PoseEdge& edge : graph.edges) edge.T_from_to = flattened(edge.T_from_to);
  return graph;
}

double largest_shift(const PoseGraph& a, const PoseGraph& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    largest = std::max(largest, (a.nodes[i].pose.translation - b.nodes[i].pose.translation).norm());
    largest = std::max(
        largest, rotation_angle(a.nodes[i].pose.rotation.conjugate() * b.nodes[i].pose.rotation));
  }
  return largest;
}

GraphOptions options_of(GraphMethod method) {
  GraphOptions options;
  options.method = method;
  options.tolerance = 1e-12;
  return options;
}

struct Shape {
  const char* name;
  PoseGraph (*make)();
};

class Shapes : public testing::TestWithParam<std::tuple<Shape, bool>> {};

TEST_P(Shapes, CondensedEndsAtTheFlatMinimum) {
  PoseGraph flat = std::get<0>(GetParam()).make();
  if (std::get<1>(GetParam())) flat = flattened(flat);
  PoseGraph condensed = flat;
  const GraphReport flat_report = optimize(flat, options_of(GraphMethod::kFlat));
  const GraphReport report = optimize(condensed, options_of(GraphMethod::kCondensed));
  ASSERT_TRUE(report.success) << report.message;
  EXPECT_EQ(report.method, "condensed");
  EXPECT_EQ(flat_report.method, "flat");
  EXPECT_NEAR(report.initial_cost, flat_report.initial_cost,
              1e-6 * flat_report.initial_cost + 1e-9);
  EXPECT_NEAR(report.final_cost, flat_report.final_cost, 1e-6 * flat_report.final_cost + 1e-6);
  EXPECT_LT(largest_shift(flat, condensed), 5e-3);
}

TEST_P(Shapes, ThreadsDoNotChangeABit) {
  PoseGraph one = std::get<0>(GetParam()).make();
  if (std::get<1>(GetParam())) one = flattened(one);
  PoseGraph two = one;
  GraphOptions options;
  options.method = GraphMethod::kCondensed;
  options.threads = 1;
  optimize(one, options);
  options.threads = 2;
  optimize(two, options);
  EXPECT_EQ(largest_shift(one, two), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Graphs, Shapes,
                         testing::Combine(testing::Values(Shape{"open_chain", open_chain},
                                                          Shape{"short_loops", short_loops},
                                                          Shape{"long_loops", long_loops},
                                                          Shape{"several_drives", several_drives},
                                                          Shape{"town", town}),
                                          testing::Bool()),
                         [](const auto& shape) {
                           return std::string(std::get<0>(shape.param).name) +
                                  (std::get<1>(shape.param) ? "_planar" : "_spatial");
                         });

TEST(CondensedGraphs, LargeOnesAreCondensedUnlessOtherwiseWanted) {
  PoseGraph graph = streets(20000, 4000);
  PoseGraph flat = graph;
  EXPECT_EQ(optimize(graph).method, "condensed");
  GraphOptions options;
  options.method = GraphMethod::kFlat;
  EXPECT_EQ(optimize(flat, options).method, "flat");
  PoseGraph small = streets(200, 0);
  EXPECT_EQ(optimize(small).method, "flat");
}

TEST(CondensedGraphs, KernelsActAsInTheFlatSolution) {
  PoseGraph flat = streets(1500, 300, 5);
  std::mt19937 engine(6);
  for (std::size_t i = flat.nodes.size(); i < flat.edges.size(); i += 20) {
    flat.edges[i].T_from_to = test::measured(flat.edges[i].T_from_to, engine, 1.0, 3.0);
  }
  for (const RobustKernel kernel : {RobustKernel::kHuber, RobustKernel::kPseudoHuber}) {
    GraphOptions options = options_of(GraphMethod::kFlat);
    options.kernel = kernel;
    options.tolerance = 1e-9;
    PoseGraph by_flat = flat, by_condensed = flat;
    const GraphReport flat_report = optimize(by_flat, options);
    options.method = GraphMethod::kCondensed;
    const GraphReport report = optimize(by_condensed, options);
    ASSERT_TRUE(report.success) << report.message;
    EXPECT_EQ(report.start, "odometry");
    EXPECT_NEAR(report.start_cost, flat_report.start_cost, 1e-6 * flat_report.start_cost);
    EXPECT_NEAR(report.final_cost, flat_report.final_cost, 1e-3 * flat_report.final_cost);
    EXPECT_LT(largest_shift(by_flat, by_condensed), 0.02);
  }
}

TEST(CondensedGraphs, RefuseTheSameLoopsAsTheFlatSolution) {
  PoseGraph graph = streets(1200, 250, 7);
  const std::size_t odometry = graph.nodes.size() - 1;
  for (std::size_t i = odometry; i < graph.edges.size(); i += 10) {
    graph.edges[i].T_from_to.translation += Eigen::Vector3d(8.0, -5.0, 1.0);
  }
  GraphOptions options;
  options.graduated = true;
  options.method = GraphMethod::kFlat;
  PoseGraph flat = graph, condensed = graph;
  const GraphReport flat_report = optimize(flat, options);
  options.method = GraphMethod::kCondensed;
  const GraphReport report = optimize(condensed, options);
  EXPECT_TRUE(report.success) << report.message;
  EXPECT_GE(report.refused.size(), (graph.edges.size() - odometry + 9) / 10);
  EXPECT_EQ(report.refused, flat_report.refused);
  EXPECT_LT(largest_shift(flat, condensed), 0.02);
}

TEST(CoarseInitialization, IsExactForExactMeasurements) {
  test::StreetSettings settings;
  settings.key_frames = 700;
  settings.loops = 100;
  settings.odometry_stddev_m = settings.odometry_stddev_deg = 1e-9;
  settings.loop_stddev_m = settings.loop_stddev_deg = 1e-9;
  settings.scale_error = settings.turn_bias_deg = 0.0;
  test::StreetGraph drive = test::make_street_graph(settings);
  for (std::size_t i = 1; i < drive.graph.nodes.size(); ++i) drive.graph.nodes[i].pose = Pose();
  ASSERT_TRUE(initialize_coarsely(drive.graph, 1));
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    const Pose& pose = drive.graph.nodes[i].pose;
    ASSERT_TRUE(test::near(pose.translation, drive.truth[i].translation, 1e-4)) << i;
  }
}

TEST(CoarseInitialization, LeavesAnUnconnectedGraphAsItIs) {
  PoseGraph graph = streets(400, 0);
  graph.edges.erase(graph.edges.begin() + 200);
  PoseGraph started = graph;
  EXPECT_FALSE(initialize_coarsely(started, 1));
  EXPECT_EQ(largest_shift(graph, started), 0.0);
}

const LossOf kNoLoss = [](const Constraint& /*constraint*/) { return nullptr; };

/// Two drives with positions, tilts, and a prior each, that loops connect; one node has no factor.
FactorGraph drives_with_positions(std::mt19937& engine) {
  test::StreetSettings settings;
  settings.key_frames = 1500;
  settings.loops = 200;
  const test::StreetGraph drive = test::make_street_graph(settings);
  FactorGraph graph;
  for (const PoseNode& node : drive.graph.nodes) graph.add_node(node.pose);
  graph.add_node(Pose());
  for (const PoseEdge& edge : drive.graph.edges) {
    if (edge.from == 699 && edge.to == 700) continue;
    graph.add({relative_pose_residual(edge.T_from_to, edge.information),
               static_cast<int>(edge.from), static_cast<int>(edge.to)});
  }
  for (const int first : {0, 700}) {
    graph.add({prior_residual(drive.truth[first], test::information_of(1.0, 5.0)), first});
  }
  std::normal_distribution<double> normal(0.0, 0.05);
  const Eigen::Vector3d lever(0.5, 0.2, 1.5);
  for (int i = 0; i < settings.key_frames; i += 25) {
    const Pose& truth = drive.truth[i];
    const Eigen::Vector3d position =
        truth * lever + Eigen::Vector3d(normal(engine), normal(engine), normal(engine));
    graph.add(
        {antenna_horizontal_residual(position, lever, 0.0025 * Eigen::Matrix2d::Identity()), i});
    graph.add({antenna_altitude_residual(position.z(), lever, 0.1), i});
    graph.add({tilt_residual(truth.rotation.conjugate() * Eigen::Vector3d::UnitZ(), 0.01), i});
  }
  return graph;
}

TEST(CondensedFactors, PositionsAndPriorsLeadToTheFlatMinimum) {
  std::mt19937 engine(8);
  FactorGraph graph = drives_with_positions(engine);
  const std::vector<bool> used(graph.constraints.size(), true);
  MinimizerSettings settings;
  settings.tolerance = 1e-12;
  const std::vector<StateBlock> start = graph.states;
  const MinimizerSummary by_flat = minimize(graph, used, kNoLoss, settings);
  const std::vector<StateBlock> flat = std::exchange(graph.states, start);
  const MinimizerSummary by_condensed = minimize_condensed(graph, used, kNoLoss, settings);
  ASSERT_TRUE(by_flat.usable) << by_flat.message;
  ASSERT_TRUE(by_condensed.usable) << by_condensed.message;
  EXPECT_NEAR(by_condensed.initial_cost, by_flat.initial_cost, 1e-9 * by_flat.initial_cost);
  EXPECT_NEAR(by_condensed.final_cost, by_flat.final_cost, 1e-6 * by_flat.final_cost);
  for (std::size_t i = 0; i < flat.size(); ++i) {
    for (std::size_t k = 0; k < 7; ++k) ASSERT_NEAR(graph.states[i][k], flat[i][k], 2e-3) << i;
  }
  EXPECT_EQ(graph.states.back(), start.back()) << "nothing moves a node without a constraint";
}

TEST(CondensedFactors, MinimizeUsesThemIfAsked) {
  std::mt19937 engine(9);
  FactorGraph graph = drives_with_positions(engine);
  const std::vector<StateBlock> start = graph.states;
  const std::vector<bool> used(graph.constraints.size(), true);
  const MinimizerSummary direct = minimize_condensed(graph, used, kNoLoss, {});
  const std::vector<StateBlock> states = std::exchange(graph.states, start);
  MinimizerSettings settings;
  settings.solver.condensed = true;
  EXPECT_EQ(minimize(graph, used, kNoLoss, settings).iterations, direct.iterations);
  EXPECT_EQ(graph.states, states);
}

TEST(CondensedFactors, UnusedConstraintsAndFixedNodesCountForNothing) {
  FactorGraph graph;
  const Matrix6d information = Matrix6d::Identity();
  graph.add_node(Pose(), true);
  graph.add_node({Eigen::Quaterniond::Identity(), {5.0, 0.0, 0.0}});
  graph.add_node({Eigen::Quaterniond::Identity(), {9.0, 0.0, 0.0}}, true);
  const Pose step = {Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}};
  graph.add({relative_pose_residual(step, information), 0, 1});
  graph.add({prior_residual({Eigen::Quaterniond::Identity(), {2.0, 0.0, 0.0}}, information), 1});
  graph.add({relative_pose_residual(step, information), 0, 2});
  graph.add({prior_residual({Eigen::Quaterniond::Identity(), {40.0, 0.0, 0.0}}, information), 1});
  const MinimizerSummary summary =
      minimize_condensed(graph, {true, true, true, false}, kNoLoss, {});
  ASSERT_TRUE(summary.usable) << summary.message;
  EXPECT_NEAR(graph.states[1][0], 1.5, 1e-6);
  EXPECT_EQ(graph.states[2][0], 9.0);
  // 64 is the edge between both fixed nodes, whose cost nothing changes.
  EXPECT_NEAR(summary.final_cost, 64.5, 1e-6);
}

TEST(CondensedFactors, WhatNothingDeterminesIsNoObstacle) {
  FactorGraph graph;
  const Pose step = {exp_so3({0.0, 0.0, 0.3}), {1.0, 0.0, 0.0}};
  for (int i = 0; i < 5; ++i) {
    graph.add_node({exp_so3({0.02 * i, 0.0, 0.25 * i}), {0.9 * i, 0.1, 0.0}});
  }
  for (int i = 0; i < 4; ++i) {
    graph.add({relative_pose_residual(step, Matrix6d::Identity()), i, i + 1});
  }
  const MinimizerSummary summary =
      minimize_condensed(graph, std::vector<bool>(4, true), kNoLoss, {});
  EXPECT_TRUE(summary.usable) << summary.message;
  EXPECT_LT(summary.final_cost, 1e-9);
}

/// A residual that is no number anywhere.
class NoNumber : public ceres::SizedCostFunction<1, kPoseBlockSize> {
 public:
  bool Evaluate(double const* const* /*blocks*/, double* residual,
                double** jacobians) const override {
    residual[0] = std::numeric_limits<double>::quiet_NaN();
    if (jacobians != nullptr) std::fill_n(jacobians[0], kPoseBlockSize, residual[0]);
    return true;
  }
};

TEST(CondensedFactors, FailureLeavesTheStates) {
  FactorGraph graph;
  graph.add_node({Eigen::Quaterniond::Identity(), {5.0, 0.0, 0.0}});
  graph.add({prior_residual(Pose(), Matrix6d::Identity()), 0});
  graph.add({std::make_unique<NoNumber>(), 0});
  const MinimizerSummary summary = minimize_condensed(graph, {true, true}, kNoLoss, {});
  EXPECT_FALSE(summary.usable);
  EXPECT_EQ(graph.states[0][0], 5.0);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
