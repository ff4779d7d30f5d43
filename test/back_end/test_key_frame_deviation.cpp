// SPDX-License-Identifier: BSD-3-Clause
// The uncertainty of key frames in the graph.

#include <cmath>

#include "lidar_mapping/back_end/key_frame_deviation.hpp"
#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "back_end_fixture.hpp"
#include "factors/drive_factors.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::add_lap_loops;
using test::feed;
using test::make_loop;
using test::optimize;
using test::SyntheticDrive;

PoseDeviation deviation_of(const Covariance6& covariance) {
  return {std::sqrt(covariance.topLeftCorner<3, 3>().trace()),
          std::sqrt(covariance.bottomRightCorner<3, 3>().trace())};
}

TEST(KeyFrameDeviation, IsEmptyWithoutKeyFrames) {
  EXPECT_TRUE(key_frame_deviations(*BackEnd(BackEndConfig{}).problem(true)).empty());
}

TEST(KeyFrameDeviation, OfAChainIsThatOfTheComposedMotions) {
  const SyntheticDrive drive = test::make_drive({1});
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  const auto problem = back_end.problem(true);
  const auto deviations = key_frame_deviations(*problem);
  ASSERT_EQ(deviations.size(), drive.key_frames.size());
  EXPECT_EQ(deviations[0].from_first.position, 0.0);
  Covariance6 composed = Covariance6::Zero();
  for (std::size_t i = 1; i < deviations.size(); ++i) {
    const Covariance6 of_motion = motion_covariance_to(problem->drive, i, problem->config);
    composed = compose_covariance(composed, motion_to(problem->drive, i), of_motion);
    const PoseDeviation first = deviation_of(composed);
    const PoseDeviation previous = deviation_of(of_motion);
    EXPECT_EQ(deviations[i].index, drive.key_frames[i].index);
    EXPECT_EQ(deviations[i].part, 0);
    EXPECT_NEAR(deviations[i].from_first.position, first.position, 1e-3 * first.position);
    EXPECT_NEAR(deviations[i].from_first.angle, first.angle, 1e-3 * first.angle);
    EXPECT_NEAR(deviations[i].from_previous.position, previous.position, 1e-3 * previous.position);
    EXPECT_NEAR(deviations[i].from_previous.angle, previous.angle, 1e-3 * previous.angle);
  }
}

/// The whole covariance matrix with the first key frame known, in blocks of 6 rows and columns.
Eigen::MatrixXd whole_inverse(const OptimizationProblem& problem) {
  const DriveFactors factors = make_factors(problem.drive, problem.config);
  const auto system = pose_graph::information_matrix(factors.graph, factors.selected);
  system->add_diagonal(0, 1e12 * Matrix6d::Identity());
  EXPECT_TRUE(system->factorize());
  const auto size = 6 * static_cast<Eigen::Index>(factors.graph.states.size());
  Eigen::MatrixXd inverse = system->solve(Eigen::MatrixXd::Identity(size, size));
  // The tangent of the graph has half angles.
  for (Eigen::Index i = 0; i < size; ++i) {
    if (i % 6 < 3) continue;
    inverse.row(i) *= 2.0;
    inverse.col(i) *= 2.0;
  }
  return inverse;
}

TEST(KeyFrameDeviation, AgreesWithTheFullInverseWithLoops) {
  test::DriveSettings settings;
  settings.spacing = 5.0;
  const SyntheticDrive drive = test::make_drive(settings);
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  feed(back_end, drive);
  add_lap_loops(back_end, drive, 80, 10, engine);
  optimize(back_end, true);
  const auto problem = back_end.problem(true);
  const Eigen::MatrixXd inverse = whole_inverse(*problem);
  const auto deviations = key_frame_deviations(*problem);
  for (std::size_t i = 1; i < deviations.size(); ++i) {
    const auto at = 6 * static_cast<Eigen::Index>(i);
    const PoseDeviation first = deviation_of(inverse.block<6, 6>(at, at));
    EXPECT_NEAR(deviations[i].from_first.position, first.position, 1e-6 * first.position) << i;
    EXPECT_NEAR(deviations[i].from_first.angle, first.angle, 1e-6 * first.angle) << i;
    // d_motion = d_this - Ad d_previous.
    const auto pose = [&](std::size_t k) { return problem->drive.nodes[k].T_map_base; };
    Eigen::Matrix<double, 6, 12> of_motion;
    of_motion << -adjoint(pose(i).inverse() * pose(i - 1)), Matrix6d::Identity();
    const PoseDeviation previous =
        deviation_of(of_motion * inverse.block<12, 12>(at - 6, at - 6) * of_motion.transpose());
    EXPECT_NEAR(deviations[i].from_previous.position, previous.position, 1e-6 * previous.position);
    EXPECT_NEAR(deviations[i].from_previous.angle, previous.angle, 1e-6 * previous.angle) << i;
  }
}

/// A lap of odometry whose errors match its covariances, without drift.
SyntheticDrive exact_lap() {
  test::DriveSettings settings;
  settings.laps = 1;
  settings.scale_error = 0.0;
  settings.turn_bias_deg = 0.0;
  return test::make_drive(settings);
}

BackEndConfig without_drift() {
  BackEndConfig config;
  config.odometry_drift = 0.0;
  config.odometry_rotation_drift = 0.0;
  return config;
}

TEST(KeyFrameDeviation, GrowsByADoubtfulStepAndShrinksByALoop) {
  SyntheticDrive drive = exact_lap();
  drive.key_frames[200].doubtful = true;
  drive.key_frames[200].motion_covariance += diagonal_covariance(20.0, 0.01);
  BackEnd back_end(without_drift());
  feed(back_end, drive);
  auto deviations = key_frame_deviations(*back_end.problem(true));
  const double expected = std::sqrt(3.0) * 20.0;
  EXPECT_TRUE(deviations[200].doubtful);
  EXPECT_FALSE(deviations[201].doubtful);
  EXPECT_LT(deviations[199].from_first.position, 0.2 * expected);
  EXPECT_NEAR(deviations[200].from_previous.position, expected, 0.01 * expected);
  EXPECT_GT(deviations[200].from_first.position, expected);
  EXPECT_LT(deviations[201].from_previous.position, 0.01 * expected);
  std::mt19937 engine(3);
  back_end.add_loop(make_loop(drive, 0, 399, engine));
  optimize(back_end, true);
  deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_LT(deviations[200].from_first.position, 0.1 * expected);
  EXPECT_LT(deviations[200].from_previous.position, 0.2 * expected);
}

TEST(KeyFrameDeviation, IsInfiniteInAnUnconnectedSegment) {
  SyntheticDrive drive = exact_lap();
  for (std::size_t i = 300; i < drive.key_frames.size(); ++i) drive.key_frames[i].segment = 1;
  BackEnd back_end(without_drift());
  feed(back_end, drive);
  auto deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_TRUE(std::isfinite(deviations[299].from_first.position));
  EXPECT_NE(deviations[300].part, deviations[299].part);
  EXPECT_TRUE(std::isinf(deviations[300].from_first.position));
  EXPECT_TRUE(std::isinf(deviations[300].from_previous.position));
  EXPECT_TRUE(std::isinf(deviations[350].from_first.position));
  EXPECT_LT(deviations[350].from_previous.position, 0.1) << "within the part all is well";
  std::mt19937 engine(3);
  back_end.add_loop(make_loop(drive, 0, 310, engine));
  optimize(back_end, true);
  deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_EQ(deviations[300].part, deviations[0].part);
  EXPECT_LT(deviations[310].from_first.position, 0.1) << "it is what the loop says";
  EXPECT_LT(deviations[310].from_first.position, deviations[300].from_first.position);
  // Through the loop, because odometry does not connect it with the previous key frame.
  EXPECT_GT(deviations[300].from_previous.position, deviations[299].from_first.position);
  EXPECT_TRUE(std::isfinite(deviations[300].from_previous.position));
}

}  // namespace
}  // namespace lidar_mapping::back_end
