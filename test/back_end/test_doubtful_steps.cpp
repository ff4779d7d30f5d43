// SPDX-License-Identifier: BSD-3-Clause
// A step of the odometry that is probably wrong, in the graph.

#include "lidar_mapping/back_end/relative_covariance.hpp"
#include "lidar_mapping/pose_graph/linearisation.hpp"

#include "back_end_fixture.hpp"
#include "factors/drive_factors.hpp"
#include "near.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::add_lap_loops;
using test::aligned_rmse;
using test::feed;
using test::make_loop;
using test::optimize;
using test::SyntheticDrive;
using test::used_count;

constexpr std::size_t kWrong = 300;  // key frame with the wrong step
constexpr int kLap = 400;            // key frames per lap

/// Error that the front end expects of such steps.
Covariance6 expected_error() { return diagonal_covariance(0.1, 0.01); }

/// Odometry turns by 90 degrees too much in the step to kWrong.
SyntheticDrive wrongly_turned_drive(bool doubtful) {
  SyntheticDrive drive = test::make_drive();
  test::add_wrong_step(drive, kWrong, {exp_so3({0.0, 0.0, M_PI / 2.0}), Eigen::Vector3d::Zero()});
  drive.key_frames[kWrong].doubtful = doubtful;
  drive.key_frames[kWrong].motion_covariance += expected_error();
  return drive;
}

struct Outcome {
  std::size_t consistent_constraints = 0;  ///< number of used loops; all loops are true
  double error = 0.0;                      ///< m
};

/// Adds a loop at every `step`th key frame of the second lap.
Outcome outcome_of(const SyntheticDrive& drive, int step) {
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  feed(back_end, drive);
  add_lap_loops(back_end, drive, kLap, step, engine);
  optimize(back_end, true);
  return {used_count(back_end), aligned_rmse(back_end, drive)};
}

TEST(DoubtfulStep, DoesNotDistortTheMapBesideTrueLoops) {
  const Outcome clean = outcome_of(test::make_drive(), 5);
  const Outcome doubted = outcome_of(wrongly_turned_drive(true), 5);
  EXPECT_EQ(doubted.consistent_constraints, 80U);
  EXPECT_LT(doubted.error, 1.1 * clean.error);
  // The same covariance, but the step is not marked as doubtful.
  const Outcome claimed = outcome_of(wrongly_turned_drive(false), 5);
  EXPECT_LT(claimed.consistent_constraints, 80U);
  EXPECT_GT(claimed.error, 5.0 * clean.error);
}

TEST(DoubtfulStep, IsCorrectedByASingleLoop) {
  const Outcome doubted = outcome_of(wrongly_turned_drive(true), kLap);
  EXPECT_EQ(doubted.consistent_constraints, 1U);
  EXPECT_LT(doubted.error, 2.0) << "what is left is drift";
  const Outcome claimed = outcome_of(wrongly_turned_drive(false), kLap);
  EXPECT_EQ(claimed.consistent_constraints, 0U);
  EXPECT_GT(claimed.error, 50.0);
}

TEST(DoubtfulStep, ConnectsTheMapIfNothingElseDoes) {
  const SyntheticDrive drive = wrongly_turned_drive(true);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  optimize(back_end, true);
  const auto poses = back_end.poses().poses;
  const Pose motion = poses[kWrong - 1].T_map_base.inverse() * poses[kWrong].T_map_base;
  const Pose odometry =
      drive.key_frames[kWrong - 1].T_odom_base.inverse() * drive.key_frames[kWrong].T_odom_base;
  EXPECT_TRUE(test::near(motion, odometry, 1e-6));
}

// The loops that are consistent without the step stay used, and false ones are still refused.
TEST(DoubtfulStep, DoesNotAcceptFalseLoopsThatOthersContradict) {
  const SyntheticDrive drive = wrongly_turned_drive(true);
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  feed(back_end, drive);
  add_lap_loops(back_end, drive, kLap, 5, engine);
  Loop wrong = make_loop(drive, 50, 500, engine);
  wrong.T_from_to = Pose();
  ASSERT_TRUE(back_end.add_loop(wrong));
  optimize(back_end, true);
  EXPECT_EQ(used_count(back_end), 80U);
  EXPECT_FALSE(back_end.loops().back().second);
}

// A step that is contradicted by 90 degrees has almost no weight in the information matrix.
TEST(DoubtfulStep, IsWeightedByItsKernelInTheInformationMatrix) {
  const SyntheticDrive drive = wrongly_turned_drive(true);
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  feed(back_end, drive);
  const auto deviation = [&] {
    const auto problem = back_end.problem(true);
    const RelativeCovariance all(*problem, kWrong - 1, RelativeCovariance::Given::kAll);
    return std::sqrt(all.of(kWrong)->topLeftCorner<3, 3>().trace());
  };
  EXPECT_NEAR(deviation(), std::sqrt(3.0) * 0.1, 0.01) << "as expected, while nothing contradicts";
  ASSERT_TRUE(back_end.add_loop(make_loop(drive, 0, kLap, engine)));
  optimize(back_end, true);
  const auto problem = back_end.problem(true);
  const DriveFactors factors = make_factors(problem->drive, problem->config);
  const pose_graph::Constraint& step = factors.graph.constraints[factors.motion_of[kWrong]];
  EXPECT_TRUE(step.doubtful);
  EXPECT_LT(pose_graph::kernel_weight(step, pose_graph::linearise(factors.graph, step).residual),
            0.01);
}

}  // namespace
}  // namespace lidar_mapping::back_end
