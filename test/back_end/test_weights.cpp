// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include <ceres/loss_function.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

#include "back_end_fixture.hpp"
#include "factors/drive_factors.hpp"
#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {
namespace {

constexpr double kDistanceInSegment = 100.0;  // m since the beginning of the segment

Pose forward(double metres) { return {Eigen::Quaterniond::Identity(), {metres, 0.0, 0.0}}; }

TEST(Weights, DriftGrowsWithTheDistance) {
  const BackEndConfig config;
  const Vector6d near = drift_stddev(forward(1.0), config);
  const Vector6d far = drift_stddev(forward(5.0), config);
  EXPECT_NEAR(far(0), 5.0 * config.odometry_drift, 0.006);
  EXPECT_GT(far(5), 3.0 * near(5));
}

// Edges of a drive of 60 m in two segments.
TEST(Weights, TheFirstMetresOfASegmentHaveLessWeight) {
  test::SyntheticDrive drive = test::make_drive({1, 60.0});
  const std::size_t second = drive.key_frames.size() / 2;
  for (std::size_t i = second; i < drive.key_frames.size(); ++i) drive.key_frames[i].segment = 1;
  BackEnd back_end(BackEndConfig{});
  test::feed(back_end, drive);
  const auto edges = back_end.graph().edges;  // none between the segments
  ASSERT_EQ(edges.size(), drive.key_frames.size() - 2);
  const auto stddev = [&](std::size_t edge) {
    return std::sqrt(edges[edge].information.inverse()(0, 0));
  };
  EXPECT_GT(stddev(0), 1.2 * stddev(second - 2));
  EXPECT_GT(stddev(second - 1), 1.2 * stddev(edges.size() - 1));
}

TEST(Weights, DegenerateDirectionsHaveLittleWeight) {
  const BackEndConfig config;
  const Covariance6 covariance =
      step_covariance(diagonal_covariance(0.001, 0.0001), forward(2.0), kDistanceInSegment,
                      {Eigen::Vector3d::UnitX()}, config);
  EXPECT_GT(std::sqrt(covariance(0, 0)), 0.3);
  EXPECT_LT(std::sqrt(covariance(1, 1)), 0.05);
}

// In a corridor, a loop without information along the corridor does not correct along it.
TEST(Weights, ALoopInACorridorDoesNotCorrectAlongTheCorridor) {
  const test::SyntheticDrive drive = test::make_drive({1, 300.0});
  std::mt19937 engine(1);
  Loop loop = test::make_loop(drive, 0, 200, engine);
  Vector6d offset = Vector6d::Zero();
  offset.head<2>() << 3.0, 0.2;
  loop.T_from_to = perturbed(drive.key_frames[200].T_odom_base, offset);
  loop.covariance = diagonal_covariance(0.02, 0.002);
  loop.covariance(0, 0) = 100.0;
  BackEnd back_end(BackEndConfig{});
  test::feed(back_end, drive);
  ASSERT_TRUE(back_end.add_loop(loop));
  test::optimize(back_end);
  const Eigen::Vector3d moved = back_end.poses().poses[200].T_map_base.translation -
                                drive.key_frames[200].T_odom_base.translation;
  EXPECT_LT(std::abs(moved.x()), 0.1);
  EXPECT_GT(moved.y(), 0.15);
}

// Constant and by fitness, as in hdl_graph_slam but with variances.
TEST(Weights, ConstantAndFitnessWeightsCanBeConfigured) {
  BackEndConfig config;
  config.use_const_inf_matrix = true;
  Loop loop;
  loop.covariance = diagonal_covariance(0.01, 0.001);
  EXPECT_NEAR(loop_covariance(loop, config)(0, 0), 0.25, 1e-12);
  EXPECT_NEAR(pose_graph::g2o_information(loop_covariance(loop, config))(5, 5), 100.0, 1e-9);
  for (const double distance_in_segment : {0.0, kDistanceInSegment}) {
    const Covariance6 step = step_covariance(loop.covariance, forward(2.0), distance_in_segment,
                                             {Eigen::Vector3d::UnitX()}, config);
    EXPECT_NEAR(step(0, 0), 0.25, 1e-12) << "whatever was measured";
    EXPECT_NEAR(step(3, 3), 0.04, 1e-12);
  }
  EXPECT_EQ(drift_stddev(forward(2.0), config).norm(), 0.0);
  config.use_const_inf_matrix = false;
  config.use_fitness_inf_matrix = true;
  loop.fitness = 0.0;
  EXPECT_NEAR(std::sqrt(loop_covariance(loop, config)(0, 0)), config.min_stddev_x, 1e-9);
  loop.fitness = 10.0;
  EXPECT_NEAR(std::sqrt(loop_covariance(loop, config)(0, 0)), config.max_stddev_x, 1e-9);
  loop.fitness = std::nan("");  // of a loop without pairs
  EXPECT_NEAR(std::sqrt(loop_covariance(loop, config)(0, 0)), config.max_stddev_x, 1e-9);
  loop.fitness = 0.01;
  // The published formula: 0.01 + 24.99 (1 - e^-0.2) / (1 - e^-10).
  EXPECT_NEAR(std::sqrt(loop_covariance(loop, config)(0, 0)), 2.131, 0.001);
}

// If the noise is as configured, chi2 per degree of freedom is about one.
TEST(Weights, ChiSquareMatchesTheDegreesOfFreedom) {
  BackEndConfig config;
  config.odometry_min_stddev_m = config.loop_min_stddev_m = 1e-6;
  config.odometry_min_stddev_rad = config.loop_min_stddev_rad = 1e-6 * kRadPerDeg;
  config.odometry_drift = config.odometry_rotation_drift = 0.0;
  test::DriveSettings settings;
  settings.scale_error = settings.turn_bias_deg = 0.0;
  const test::SyntheticDrive drive = test::make_drive(settings);
  BackEnd back_end(config);
  test::feed(back_end, drive);
  std::mt19937 engine(7);
  test::add_lap_loops(back_end, drive, 400, 2, engine);
  const OptimizationReport report = test::optimize(back_end);
  // 200 loops of six dimensions close the graph, which is the number of degrees of freedom.
  EXPECT_NEAR(report.cost_after / (6.0 * 200.0), 1.0, 0.15);
}

TEST(Weights, KernelsAreQuadraticUpToTheirSize) {
  double rho[3];
  const auto huber = pose_graph::make_kernel(pose_graph::RobustKernel::kHuber, 2.0);
  huber->Evaluate(1.0, rho);
  EXPECT_EQ(rho[1], 1.0);
  const auto dcs = pose_graph::make_kernel(pose_graph::RobustKernel::kDcs, 2.0);
  dcs->Evaluate(4.0, rho);
  EXPECT_NEAR(rho[0], 4.0, 1e-12);
  dcs->Evaluate(1e9, rho);
  EXPECT_NEAR(rho[0], 12.0, 1e-6);
  const auto geman = pose_graph::make_kernel(pose_graph::RobustKernel::kGemanMcClure, 2.0);
  geman->Evaluate(1e9, rho);
  EXPECT_NEAR(rho[0], 4.0, 1e-6);
  EXPECT_EQ(pose_graph::make_kernel(pose_graph::RobustKernel::kNone, 1.0), nullptr);
}

TEST(Weights, KernelsHaveTheirDefinedLimits) {
  const auto pull = [](pose_graph::RobustKernel kernel, double s) {
    double rho[3];
    pose_graph::make_kernel(kernel, 2.0)->Evaluate(s, rho);
    return rho[1];
  };
  for (const auto& [name, kernel] : pose_graph::robust_kernel_names()) {
    if (kernel == pose_graph::RobustKernel::kNone) continue;
    EXPECT_NEAR(pull(kernel, 0.0), 1.0, 1e-12) << name;
    EXPECT_LT(pull(kernel, 1e4), 0.03) << name;
  }
  EXPECT_EQ(pull(pose_graph::RobustKernel::kSaturated, 4.1), 0.0);
  EXPECT_EQ(pull(pose_graph::RobustKernel::kTukey, 4.1), 0.0);
  EXPECT_NEAR(pull(pose_graph::RobustKernel::kFair, 4.0), 0.5, 1e-12);
  EXPECT_NEAR(pull(pose_graph::RobustKernel::kPseudoHuber, 12.0), 0.5, 1e-12);
  EXPECT_NEAR(pull(pose_graph::RobustKernel::kWelsch, 4.0), std::exp(-1.0), 1e-12);
}

TEST(Weights, KernelNamesAreThoseOfG2oInUpperOrLowerCase) {
  for (const char* name : {"NONE", "Huber", "Cauchy", "DCS", "Fair", "GemanMcClure", "PseudoHuber",
                           "Saturated", "Tukey", "Welsch", "tukey", "PSEUDOHUBER", "dcs"}) {
    EXPECT_NO_THROW(pose_graph::robust_kernel_of(name)) << name;
    const std::string text = std::string("loop_robust_kernel: ") + name + "\n";
    const auto config = config::load<BackEndConfig>({config::parse_yaml(text, "back_end.yaml")});
    EXPECT_EQ(config.loop_robust_kernel, pose_graph::robust_kernel_of(name)) << name;
  }
  EXPECT_THROW(pose_graph::robust_kernel_of("Tuckey"), InputError);
}

TEST(BackEndConfig, AcceptsTheNamesOfHdlGraphSlam) {
  const auto config = config::load<BackEndConfig>({config::parse_yaml(
      "enable_gps: false\ngraph_update_interval: 3.0\nodometry_edge_robust_kernel: NONE\n"
      "loop_closure_edge_robust_kernel: Huber\ngps_edge_robust_kernel: Cauchy\n"
      "imu_orientation_edge_robust_kernel: DCS\nfloor_edge_robust_kernel: Tukey\n",
      "hdl")});
  EXPECT_FALSE(config.use_gnss);
  EXPECT_EQ(config.optimize_min_interval, 3.0);
  EXPECT_EQ(config.odometry_robust_kernel, pose_graph::RobustKernel::kNone);
  EXPECT_EQ(config.loop_robust_kernel, pose_graph::RobustKernel::kHuber);
  EXPECT_EQ(config.gnss_robust_kernel, pose_graph::RobustKernel::kCauchy);
  EXPECT_EQ(config.imu_robust_kernel, pose_graph::RobustKernel::kDcs);
  EXPECT_EQ(config.floor_robust_kernel, pose_graph::RobustKernel::kTukey);
  const auto other = config::load<BackEndConfig>(
      {config::parse_yaml("imu_acceleration_edge_robust_kernel: Fair\n", "hdl")});
  EXPECT_EQ(other.imu_robust_kernel, pose_graph::RobustKernel::kFair);
}

/// One of each kind of constraint.
DriveGraph graph_of_all_kinds() {
  DriveGraph drive;
  drive.nodes.resize(3);
  drive.nodes[1].connected = drive.nodes[2].connected = true;
  drive.in_enu = {true};
  drive.gnss_delays.resize(1);
  drive.segment_starts = {0};
  DriveLoop loop;
  loop.to = 2;
  drive.loops.push_back(loop);
  DriveGnss gnss;
  gnss.node = 1;
  gnss.position.R_enu_base = Eigen::Quaterniond::Identity();
  drive.gnss.push_back(gnss);
  DriveImu imu;
  imu.node = 1;
  imu.sample.orientation = Eigen::Quaterniond::Identity();
  imu.sample.linear_acceleration = {0.0, 0.0, 9.81};
  drive.imu.push_back(imu);
  for (const int node : {1, 2}) {
    DriveFloor floor;
    floor.node = node;
    floor.floor.found = true;
    floor.floor.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    drive.floors.push_back(floor);
  }
  return drive;
}

/// Numbers of constraints with this kernel and this size.
std::ptrdiff_t count_kernels(const DriveFactors& factors, pose_graph::RobustKernel kernel,
                             double size) {
  const auto& all = factors.graph.constraints;
  return std::count_if(all.begin(), all.end(), [&](const pose_graph::Constraint& constraint) {
    return constraint.kernel == kernel && constraint.kernel_size == size;
  });
}

TEST(Weights, EveryKindOfConstraintHasItsKernelAndTheSize) {
  using pose_graph::RobustKernel;
  BackEndConfig config;
  config.enable_imu_heading = config.enable_imu_acceleration = true;
  config.odometry_robust_kernel = RobustKernel::kFair;
  config.loop_robust_kernel = RobustKernel::kDcs;
  config.gnss_robust_kernel = RobustKernel::kTukey;
  config.imu_robust_kernel = RobustKernel::kWelsch;
  config.floor_robust_kernel = RobustKernel::kSaturated;
  for (const double size : {0.7, 2.5}) {
    config.robust_kernel_size = size;
    for (const FloorConstraint kind : {FloorConstraint::kNeighbours, FloorConstraint::kPlane}) {
      config.floor_constraint = kind;
      const DriveFactors factors = make_factors(graph_of_all_kinds(), config);
      EXPECT_EQ(count_kernels(factors, RobustKernel::kFair, size), 2) << "motions";
      EXPECT_EQ(count_kernels(factors, RobustKernel::kDcs, size), 1) << "loops";
      EXPECT_EQ(count_kernels(factors, RobustKernel::kTukey, size), 2) << "horizontal, altitude";
      EXPECT_EQ(count_kernels(factors, RobustKernel::kWelsch, size), 3)
          << "orientation, acceleration, heading";
      EXPECT_EQ(count_kernels(factors, RobustKernel::kSaturated, size),
                kind == FloorConstraint::kNeighbours ? 1 : 2)
          << "floors";
    }
  }
}

TEST(Weights, KernelsHaveExactDerivatives) {
  for (const auto& [name, kernel] : pose_graph::robust_kernel_names()) {
    const auto loss = pose_graph::make_kernel(kernel, 1.5);
    if (!loss) continue;
    for (const double s : {0.5, 3.0, 20.0}) {
      constexpr double kStep = 1e-5;
      double at[3], ahead[3], behind[3];
      loss->Evaluate(s, at);
      loss->Evaluate(s + kStep, ahead);
      loss->Evaluate(s - kStep, behind);
      EXPECT_NEAR(at[1], (ahead[0] - behind[0]) / (2.0 * kStep), 1e-7) << name << " at " << s;
      EXPECT_NEAR(at[2], (ahead[1] - behind[1]) / (2.0 * kStep), 1e-7) << name << " at " << s;
    }
  }
}

TEST(Config, RefusesContradictingParameters) {
  const auto load = [](const std::string& text) {
    return config::load<BackEndConfig>({config::parse_yaml(text, "back_end.yaml")});
  };
  EXPECT_THROW(load("use_const_inf_matrix: true\nuse_fitness_inf_matrix: true\n"), ConfigError);
  EXPECT_THROW(load("use_gnss: false\ngeoreference_only: true\n"), ConfigError);
  EXPECT_THROW(load("min_stddev_x: 6.0\n"), ConfigError);
  EXPECT_EQ(load("loop_robust_kernel: DCS\n").loop_robust_kernel, pose_graph::RobustKernel::kDcs);
}

}  // namespace
}  // namespace lidar_mapping::back_end
