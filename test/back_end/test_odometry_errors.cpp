// SPDX-License-Identifier: BSD-3-Clause

#include "lidar_mapping/pose_graph/robust_solver.hpp"

#include "back_end_fixture.hpp"
#include "near.hpp"
#include "optimization.hpp"
#include "weights/drift_fraction.hpp"
#include "weights/systematic_errors.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::feed;
using test::optimize;
using test::SyntheticDrive;

/// A drive of 1.6 km whose odometry has only the given errors.
SyntheticDrive good_drive(double stddev_m, double scale_error = 0.0) {
  test::DriveSettings settings;
  settings.laps = 4;
  settings.spacing = 2.0;
  settings.odometry_stddev_m = stddev_m;
  settings.odometry_stddev_deg = 0.0005;
  settings.turn_bias_deg = 0.0;
  settings.scale_error = scale_error;
  return test::make_drive(settings);
}

void add_positions(BackEnd& back_end, const SyntheticDrive& drive, std::size_t end, double sigma) {
  std::mt19937 engine(3);
  for (std::size_t i = 0; i < end; ++i) {
    back_end.add_gnss(test::make_gnss(drive, static_cast<int>(i), engine, sigma));
  }
}

const OdometryErrors& estimated_errors(const OptimizationProblem& problem) {
  return problem.drive.odometry_errors;
}

TEST(OdometryErrors, AScaleErrorIsEstimatedAndCorrected) {
  const SyntheticDrive drive = good_drive(0.001, 2e-4);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  add_positions(back_end, drive, 600, 0.02);
  optimize(back_end, true);
  EXPECT_NEAR(estimated_errors(*back_end.problem()).scale_error, -2e-4, 8e-5);
  const Pose by_odometry = drive.key_frames[698].T_odom_base.inverse() *  //
                           drive.key_frames[699].T_odom_base;
  const pose_graph::PoseGraph graph = back_end.graph();  // no position is near this motion
  EXPECT_NEAR(graph.edges[698].T_from_to.translation.norm() / by_odometry.translation.norm(),
              1.0 - 2e-4, 8e-5);
}

// The error of three metres could be taken for a scale error of 0.2 % and for the full drift.
TEST(OdometryErrors, AWrongDoubtfulStepDoesNotInfluenceThem) {
  SyntheticDrive drive = good_drive(0.0005, 2e-4);
  test::add_wrong_step(drive, 300, {Eigen::Quaterniond::Identity(), {3.0, 0.0, 0.0}});
  drive.key_frames[300].doubtful = true;
  drive.key_frames[300].motion_covariance += diagonal_covariance(2.0, 0.02);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  add_positions(back_end, drive, 800, 0.02);
  optimize(back_end, true);
  EXPECT_NEAR(estimated_errors(*back_end.problem()).scale_error, -2e-4, 8e-5);
  EXPECT_LT(estimated_errors(*back_end.problem()).drift_fraction.maxCoeff(), 0.75);
  EXPECT_LT(test::true_rmse(back_end, drive), 0.05);
}

TEST(OdometryErrors, SmallAndLargeDriftAreDistinguished) {
  for (const double sigma : {0.02, 1.0}) {
    BackEnd good(BackEndConfig{});
    feed(good, good_drive(0.0005));
    add_positions(good, good_drive(0.0005), 800, sigma);
    optimize(good, true);
    EXPECT_LT(estimated_errors(*good.problem()).drift_fraction.maxCoeff(), 0.75) << sigma;
  }
  BackEnd bad(BackEndConfig{});
  feed(bad, good_drive(0.02));
  add_positions(bad, good_drive(0.02), 800, 0.02);
  optimize(bad, true);
  EXPECT_GT(estimated_errors(*bad.problem()).drift_fraction.head<3>().minCoeff(), 0.85);
}

TEST(OdometryErrors, AreAsConfiguredWithoutOrWithFewPositions) {
  const SyntheticDrive drive = good_drive(0.0005);
  for (const std::size_t count : {0, 60}) {
    BackEnd back_end(BackEndConfig{});
    feed(back_end, drive);
    add_positions(back_end, drive, count, 0.02);
    optimize(back_end, true);
    EXPECT_TRUE(estimated_errors(*back_end.problem()).drift_fraction.isOnes(0.0)) << count;
  }
}

TEST(OdometryErrors, FixesOfAMetreHardlyDisturbGoodOdometry) {
  const SyntheticDrive drive = good_drive(0.0005);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  add_positions(back_end, drive, 800, 1.0);
  optimize(back_end, true);
  EXPECT_LT(test::aligned_rmse(back_end, drive), 0.095);
}

// The delay of the drive is wrong by 4 ms, and the estimated lever arm by centimetres.
TEST(SystematicErrors, TheErrorOfACorrectedDelayIsEstimated) {
  const SyntheticDrive drive = good_drive(0.001);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  add_positions(back_end, drive, 800, 0.02);
  optimize(back_end, true);
  const auto problem = back_end.problem();
  for (const double wrong : {-0.004, 0.004}) {
    const Eigen::Vector2d lever_arm_error(0.0, 5.0 * wrong);
    DriveGraph changed = problem->drive;
    changed.gnss_delays[0] = {wrong, 0.003, lever_arm_error};
    DriveFactors factors = make_factors(changed, problem->config);
    const pose_graph::RobustSolution solution =
        pose_graph::solve_selected(factors.graph, factors.selected);
    const double scatter = position_scatter(factors, solution.used);
    const SystematicErrors found =
        estimate_systematic_errors(changed, factors, solution.used, scatter);
    EXPECT_NEAR(found.delay, -wrong, 0.001);
    EXPECT_TRUE(test::near(found.lever_arm, -lever_arm_error, 0.005))
        << found.lever_arm.transpose();
  }
}

// After a change of the weights the poses are no longer at the minimum.
TEST(SystematicErrors, AreTheSameFromPosesWithOtherWeights) {
  const SyntheticDrive drive = good_drive(0.001, 1e-4);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  add_positions(back_end, drive, 800, 0.02);
  optimize(back_end, true);
  const auto problem = back_end.problem();
  DriveGraph changed = problem->drive;
  changed.gnss_delays[0] = {0.004, 0.003, Eigen::Vector2d::Zero()};
  changed.odometry_errors.drift_fraction.setConstant(0.2);
  DriveFactors factors = make_factors(changed, problem->config);
  const std::vector<bool> used = factors.selected;
  const SystematicErrors found = estimate_systematic_errors(changed, factors, used, 0.2);
  ASSERT_TRUE(pose_graph::solve_selected(factors.graph, used).success);
  const SystematicErrors at_minimum = estimate_systematic_errors(changed, factors, used, 0.2);
  EXPECT_NEAR(found.delay, -0.004, 0.001);
  EXPECT_NEAR(found.delay, at_minimum.delay, 5e-5);
  EXPECT_NEAR(found.scale_error, at_minimum.scale_error, 1e-6);
  EXPECT_TRUE(test::near(found.lever_arm, at_minimum.lever_arm, 5e-4));
}

}  // namespace
}  // namespace lidar_mapping::back_end
