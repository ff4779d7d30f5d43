// SPDX-License-Identifier: BSD-3-Clause
#include <future>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/common/errors.hpp"

#include "back_end_fixture.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::DriveSettings;
using test::SyntheticDrive;

using test::add_lap_loops;
using test::feed;
using test::optimize;

TEST(BackEnd, FollowsOdometryWithoutOtherConstraints) {
  const SyntheticDrive drive = test::make_drive({1});
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  EXPECT_TRUE(test::near(back_end.poses().poses.back().T_map_base.translation,
                         drive.key_frames.back().T_odom_base.translation, 1e-9));
  EXPECT_FALSE(back_end.optimization_due());
}

TEST(BackEnd, OptimisesAfterTheConfiguredNumbersOfNewData) {
  const SyntheticDrive drive = test::make_drive();
  std::mt19937 engine(5);
  const auto key_frames = [&](BackEnd& back_end, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) back_end.add_key_frame(drive.key_frames[i]);
  };
  BackEndConfig config;
  config.optimize_step_with_loop = 3;
  config.optimize_step_with_key_frame = 20;
  config.optimize_step_with_gnss = 7;
  BackEnd with_loops(config);
  key_frames(with_loops, 0, 410);
  with_loops.add_loop(make_loop(drive, 0, 400, engine));
  with_loops.add_loop(make_loop(drive, 1, 401, engine));
  EXPECT_TRUE(with_loops.optimization_due()) << "410 key frames are more than 20";
  optimize(with_loops);
  key_frames(with_loops, 410, 429);
  with_loops.add_loop(make_loop(drive, 2, 402, engine));
  with_loops.add_loop(make_loop(drive, 3, 403, engine));
  EXPECT_FALSE(with_loops.optimization_due()) << "2 loops, 19 key frames";
  with_loops.add_loop(make_loop(drive, 4, 404, engine));
  EXPECT_TRUE(with_loops.optimization_due()) << "3 loops";
  optimize(with_loops);
  key_frames(with_loops, 429, 448);
  EXPECT_FALSE(with_loops.optimization_due()) << "19 key frames";
  key_frames(with_loops, 448, 449);
  EXPECT_TRUE(with_loops.optimization_due()) << "20 key frames";

  config.optimize_step_with_key_frame = 10000;
  BackEnd with_gnss(config);
  key_frames(with_gnss, 0, 100);
  const auto positions = [&](int begin, int end) {
    for (int i = begin; i < end; ++i) with_gnss.add_gnss(test::make_gnss(drive, i, engine, 0.02));
  };
  positions(0, 60);
  optimize(with_gnss);
  key_frames(with_gnss, 100, 120);
  positions(60, 66);
  EXPECT_FALSE(with_gnss.optimization_due()) << "6 positions";
  positions(66, 67);
  EXPECT_TRUE(with_gnss.optimization_due()) << "7 positions";
}

TEST(BackEnd, LoopsRemoveDriftWithoutAnyOtherSensor) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  const double before = test::position_rmse(back_end.poses().poses, drive.truth, true);
  std::mt19937 engine(5);
  add_lap_loops(back_end, drive, 400, 5, engine);
  EXPECT_TRUE(back_end.optimization_due());
  const OptimizationReport report = optimize(back_end);
  EXPECT_TRUE(report.success) << report.message;
  EXPECT_EQ(report.loops_refused, 0U);
  EXPECT_LT(report.cost_after, report.cost_before);
  const double after = test::position_rmse(back_end.poses().poses, drive.truth, true);
  EXPECT_LT(after, 0.3);
  EXPECT_LT(after, 0.3 * before);
  EXPECT_FALSE(back_end.optimization_due());
  EXPECT_EQ(report.least_eigenvalue, 0.0) << "only a thorough solution takes the time for it";
  EXPECT_GT(optimize(back_end, true).least_eigenvalue, 0.0);
}

/// Adds the first half of a drive, solves it, adds the second half and applies the solution. The
/// solver runs either in a thread of its own while the graph grows, or before.
KeyFramePoses solved_while_growing(const SyntheticDrive& drive, std::launch policy) {
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  const std::size_t half = drive.truth.size() / 2 + 100;
  std::future<std::shared_ptr<const OptimizationSolution>> solution;
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    if (i == half) {
      solution = std::async(policy, [problem = back_end.problem(true)] { return solve(*problem); });
      if (policy == std::launch::deferred) solution.wait();
    }
    back_end.add_key_frame(drive.key_frames[i]);
    back_end.add_gnss(test::make_gnss(drive, static_cast<int>(i), engine, 0.05));
    if (i >= 400 && i % 5 == 0) {
      back_end.add_loop(
          test::make_loop(drive, static_cast<int>(i) - 400, static_cast<int>(i), engine));
    }
    EXPECT_EQ(back_end.poses().poses.size(), i + 1);
  }
  return back_end.apply(*solution.get());
}

// A solver in another thread shares no data that change with the graph.
TEST(BackEnd, SolvesInAnotherThreadWhileDataArrive) {
  const SyntheticDrive drive = test::make_drive();
  const KeyFramePoses one_after_the_other = solved_while_growing(drive, std::launch::deferred);
  const KeyFramePoses at_once = solved_while_growing(drive, std::launch::async);
  ASSERT_EQ(at_once.poses.size(), one_after_the_other.poses.size());
  for (std::size_t i = 0; i < at_once.poses.size(); ++i) {
    EXPECT_EQ(difference(at_once.poses[i].T_map_base, one_after_the_other.poses[i].T_map_base),
              Vector6d::Zero());
  }
}

TEST(BackEnd, GnssGivesTheMapPositionAndHeading) {
  DriveSettings settings;
  settings.start_yaw = 2.0;
  const SyntheticDrive drive = test::make_drive(settings);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  for (int i = 0; i < static_cast<int>(drive.truth.size()); ++i) {
    back_end.add_gnss(test::make_gnss(drive, i, engine, 0.02));
  }
  add_lap_loops(back_end, drive, 400, 5, engine);
  const OptimizationReport report = optimize(back_end);
  EXPECT_TRUE(report.success) << report.message;
  EXPECT_LT(test::position_rmse(back_end.poses().poses, drive.truth, false), 0.1);
}

TEST(BackEnd, ParametersSwitchConstraintsOff) {
  const SyntheticDrive drive = test::make_drive();
  BackEndConfig config;
  config.use_gnss = false;
  config.use_loop_close = false;
  BackEnd back_end(config);
  feed(back_end, drive);
  std::mt19937 engine(5);
  for (int i = 0; i < 800; ++i) back_end.add_gnss(test::make_gnss(drive, i, engine, 0.02));
  add_lap_loops(back_end, drive, 400, 5, engine);
  EXPECT_FALSE(back_end.optimization_due());
  const OptimizationReport report = optimize(back_end);
  EXPECT_EQ(report.loops_used, 0U);
  EXPECT_EQ(report.gnss_used, 0U);
  EXPECT_TRUE(test::near(back_end.poses().poses.back().T_map_base.translation,
                         drive.key_frames.back().T_odom_base.translation, 1e-6));
}

TEST(BackEnd, RefusesLoopsWithInvalidIndices) {
  const SyntheticDrive drive = test::make_drive({1});
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  Loop loop = test::make_loop(drive, 0, 399, engine);
  loop.to = 100000;
  EXPECT_FALSE(back_end.add_loop(loop));
  loop.to = loop.from;
  EXPECT_FALSE(back_end.add_loop(loop));
  loop = test::make_loop(drive, 399, 0, engine);
  EXPECT_TRUE(back_end.add_loop(loop)) << "a loop that runs backwards is still a loop";
}

TEST(BackEnd, KeepsDataThatArriveDuringASolution) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  for (int i = 0; i < 700; ++i) back_end.add_key_frame(drive.key_frames[i]);
  std::mt19937 engine(5);
  for (int i = 400; i < 700; i += 5) back_end.add_loop(test::make_loop(drive, i - 400, i, engine));
  const auto problem = back_end.problem();
  for (std::size_t i = 700; i < 800; ++i) back_end.add_key_frame(drive.key_frames[i]);
  back_end.add_loop(test::make_loop(drive, 399, 799, engine));
  const KeyFramePoses moved = back_end.apply(*solve(*problem));
  EXPECT_EQ(moved.poses.size(), 800U);
  EXPECT_EQ(back_end.loops().size(), 61U);
  const Pose T_699_799 =
      drive.key_frames[699].T_odom_base.inverse() * drive.key_frames[799].T_odom_base;
  const Pose expected = moved.poses[699].T_map_base * T_699_799;
  EXPECT_TRUE(test::near(moved.poses[799].T_map_base.translation, expected.translation, 1e-9));
}

TEST(BackEnd, ThrowsForIndicesThatDoNotIncrease) {
  const SyntheticDrive drive = test::make_drive({1});
  BackEnd back_end(BackEndConfig{});
  back_end.add_key_frame(drive.key_frames[1]);
  EXPECT_THROW(back_end.add_key_frame(drive.key_frames[0]), InputError);
}

}  // namespace
}  // namespace lidar_mapping::back_end
