// SPDX-License-Identifier: BSD-3-Clause
// The package's Gauss-Newton steps against the Levenberg-Marquardt method of Ceres: the same graph,
// residuals, start and tolerance, one thread. Public graphs lie in LIDAR_MAPPING_TEST_DATA.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "lidar_mapping/pose_graph/factor_graph.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"

#include "initialization/chordal_initialization.hpp"
#include "initialization/odometry_chain.hpp"
#include "synthetic_drive.hpp"
#include "test_data.hpp"

namespace lidar_mapping::pose_graph {
namespace {

constexpr double kTolerance = 1e-9;  // of the cost, so that both reach the same minimum
constexpr double kRadius = 1e4;      // of the first trust region: the default of Ceres

CostPtr residual_of(const PoseEdge& edge, bool planar) {
  if (!planar) return relative_pose_residual(edge.T_from_to, edge.information);
  const Pose& T = edge.T_from_to;
  Eigen::Matrix3d information;
  information << edge.information.topLeftCorner<2, 2>(), edge.information.block<2, 1>(0, 5),
      edge.information.block<1, 2>(5, 0), edge.information(5, 5);
  return planar_relative_pose_residual({T.translation.x(), T.translation.y(), yaw_of(T.rotation)},
                                       information);
}

/// The factors of a graph, at the poses of its nodes; the first node is fixed.
FactorGraph factors_of(const PoseGraph& graph) {
  FactorGraph factors;
  factors.planar = graph.planar;
  for (const PoseNode& node : graph.nodes) {
    factors.add_node(node.pose, &node == &graph.nodes.front());
  }
  const auto ends = edge_positions(graph);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    Constraint constraint;
    constraint.residual = residual_of(graph.edges[i], graph.planar);
    constraint.first = ends[i].first;
    constraint.second = ends[i].second;
    factors.add(std::move(constraint));
  }
  return factors;
}

/// Laps of a square street at the poses of odometry, with a loop at every fifth key frame from the
/// second lap on.
PoseGraph laps(int count, unsigned seed) {
  test::DriveSettings settings;
  settings.laps = count;
  settings.seed = seed;
  const test::SyntheticDrive drive = test::make_drive(settings);
  std::mt19937 engine(seed);
  const Matrix6d odometry = g2o_information(diagonal_covariance(0.02, 0.001));
  const Matrix6d loop = g2o_information(diagonal_covariance(0.02, 0.002));
  const int nodes = static_cast<int>(drive.key_frames.size());
  const int lap = nodes / count;
  PoseGraph graph;
  for (int i = 0; i < nodes; ++i) {
    const Pose& T_odom_now = drive.key_frames[i].T_odom_base;
    graph.nodes.push_back({i, T_odom_now});
    if (i == 0) continue;
    const Pose& T_odom_last = drive.key_frames[i - 1].T_odom_base;
    graph.edges.push_back({i - 1, i, T_odom_last.inverse() * T_odom_now, odometry});
  }
  for (int i = lap; i < nodes; i += 5) {
    graph.edges.push_back({i - lap, i, test::make_loop(drive, i - lap, i, engine).T_from_to, loop});
  }
  return graph;
}

/// Solves the graph from its poses again and again.
void solve(benchmark::State& state, const std::shared_ptr<const PoseGraph>& graph, bool own) {
  FactorGraph factors = factors_of(*graph);
  const std::vector<StateBlock> start = factors.states;
  const std::vector<bool> all(factors.constraints.size(), true);
  const LossOf least_squares = [](const Constraint& /*constraint*/) { return nullptr; };
  MinimizerSettings settings;
  settings.max_iterations = 200;
  settings.tolerance = kTolerance;
  if (!own) settings.initial_radius = kRadius;
  MinimizerSummary summary;
  for (auto _ : state) {
    state.PauseTiming();
    factors.states = start;
    state.ResumeTiming();
    summary = minimize(factors, all, least_squares, settings);
  }
  if (!summary.usable) state.SkipWithError(summary.message.c_str());
  state.counters["nodes"] = static_cast<double>(graph->nodes.size());
  state.counters["edges"] = static_cast<double>(graph->edges.size());
  state.counters["iterations"] = summary.iterations;
  state.counters["cost"] = summary.final_cost;
}

void register_graph(const std::string& name, PoseGraph graph) {
  const auto shared = std::make_shared<const PoseGraph>(std::move(graph));
  for (const bool own : {true, false}) {
    benchmark::RegisterBenchmark((name + (own ? "/own" : "/ceres")).c_str(), solve, shared, own)
        ->Unit(benchmark::kMillisecond);
  }
}

/// From the chordal relaxation, as optimize_graph does, and from the chain of odometry.
void register_both_starts(const std::string& name, PoseGraph graph) {
  initialize_along_edges(graph, {std::vector<bool>(graph.nodes.size(), false)});
  register_graph(name + "/odometry", graph);
  if (initialize_chordally(graph)) register_graph(name + "/chordal", std::move(graph));
}

void register_public_graphs() {
  const std::filesystem::path folder = test::recorded("pose_graphs");
  if (folder.empty()) {
    std::fprintf(stderr, "public graphs are left out; set LIDAR_MAPPING_TEST_DATA\n");
    return;
  }
  for (const char* name : {"intel", "manhattan", "kitti_00", "parking-garage", "sphere2500",
                           "torus3D", "cubicle", "sphere_bignoise"}) {
    register_both_starts(name, read_g2o(folder / (std::string(name) + ".g2o")).graph);
  }
}

}  // namespace
}  // namespace lidar_mapping::pose_graph

int main(int argc, char** argv) {
  using namespace lidar_mapping::pose_graph;
  benchmark::Initialize(&argc, argv);
  for (const unsigned seed : {1U, 2U}) {
    register_both_starts("laps_5_seed_" + std::to_string(seed), laps(5, seed));
  }
  register_both_starts("laps_25", laps(25, 3));
  register_public_graphs();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
