// SPDX-License-Identifier: BSD-3-Clause
#include "back_end_fixture.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::add_lap_loops;
using test::aligned_rmse;
using test::DriveSettings;
using test::feed;
using test::make_loop;
using test::optimize;
using test::SyntheticDrive;
using test::used_count;

/// False loops between locations that are far apart, in consistent groups of ten.
void add_false_loops(BackEnd& back_end, const SyntheticDrive& drive, int groups,
                     std::mt19937& engine) {
  std::uniform_int_distribution<int> pick(0, 150);
  for (int group = 0; group < groups; ++group) {
    const int from = pick(engine);
    const int to = from + 130 + 40 * group;
    for (int k = 0; k < 10; ++k) {
      Loop loop = make_loop(drive, from + k, to + k, engine);
      loop.T_from_to = Pose();
      EXPECT_TRUE(back_end.add_loop(loop));
    }
  }
}

TEST(Loops, FalseLoopsHardlyChangeTheMap) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd clean(BackEndConfig{});
  BackEnd spoiled(BackEndConfig{});
  for (BackEnd* back_end : {&clean, &spoiled}) {
    std::mt19937 engine(5);
    feed(*back_end, drive);
    add_lap_loops(*back_end, drive, 400, 5, engine);
  }
  std::mt19937 engine(6);
  add_false_loops(spoiled, drive, 4, engine);
  optimize(clean);
  const OptimizationReport report = optimize(spoiled);
  EXPECT_EQ(report.loops_used, 80U);
  EXPECT_EQ(report.loops_refused, 40U);
  EXPECT_LT(aligned_rmse(spoiled, drive), 1.1 * aligned_rmse(clean, drive));
}

TEST(Loops, AUsedLoopIsRefusedWhenOthersContradictIt) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  // A single loop with an error of a few metres cannot be distinguished from drift.
  Loop wrong = make_loop(drive, 0, 400, engine);
  wrong.T_from_to.translation.y() += 1.5;
  back_end.add_loop(wrong);
  optimize(back_end);
  ASSERT_TRUE(back_end.loops().front().second);
  add_lap_loops(back_end, drive, 400, 5, engine);
  optimize(back_end);
  EXPECT_FALSE(back_end.loops().front().second);
  EXPECT_EQ(used_count(back_end, 1, 81), 80U);
}

TEST(Loops, ARefusedLoopIsUsedWhenOthersConfirmIt) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  add_false_loops(back_end, drive, 2, engine);
  const Loop lone = make_loop(drive, 10, 410, engine);
  back_end.add_loop(lone);
  optimize(back_end);
  add_lap_loops(back_end, drive, 400, 5, engine);
  optimize(back_end, true);
  EXPECT_TRUE(back_end.loops()[20].second);
  EXPECT_EQ(used_count(back_end, 0, 20), 0U);
}

TEST(Loops, FourKeyFramesAndOneLoopAreSolved) {
  DriveSettings settings;
  settings.side = 100.0;
  settings.spacing = 100.0;
  settings.laps = 1;
  const SyntheticDrive drive = test::make_drive(settings);
  ASSERT_EQ(drive.key_frames.size(), 4U);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  back_end.add_loop(make_loop(drive, 0, 3, engine));
  EXPECT_TRUE(back_end.optimization_due());
  EXPECT_TRUE(optimize(back_end).success);
  const auto poses = back_end.poses().poses;
  const Pose apart = poses[0].T_map_base.inverse() * poses[3].T_map_base;
  EXPECT_TRUE(
      test::near(apart.translation, (drive.truth[0].inverse() * drive.truth[3]).translation, 0.2));
}

TEST(Loops, AnOptimisationWithoutNewDataMovesNothing) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  add_lap_loops(back_end, drive, 400, 5, engine);
  optimize(back_end);
  const auto before = back_end.poses().poses;
  EXPECT_LE(optimize(back_end).iterations, 1);
  const auto after = back_end.poses().poses;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(
        test::near(after[i].T_map_base.translation, before[i].T_map_base.translation, 1e-4));
  }
}

TEST(Loops, AreLeftOutWhereTheyAreNotUsed) {
  const SyntheticDrive drive = test::make_drive();
  BackEndConfig config;
  config.use_loop_close = false;
  BackEnd back_end(config);
  feed(back_end, drive);
  std::mt19937 engine(5);
  back_end.add_loop(make_loop(drive, 0, 400, engine));
  EXPECT_FALSE(back_end.loops().front().second);
  const OptimizationReport report = optimize(back_end, true);
  EXPECT_EQ(report.loops_used, 0U);
  EXPECT_EQ(report.loops_refused, 1U);
  EXPECT_FALSE(back_end.loops().front().second);
  EXPECT_FALSE(back_end.optimization_due());
}

// The first loop is optimised at once, the next one after the least interval.
TEST(Loops, AreOptimisedSoonAndNotTooOften) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  for (std::size_t i = 0; i <= 400; ++i) back_end.add_key_frame(drive.key_frames[i]);
  back_end.add_loop(make_loop(drive, 0, 400, engine));
  EXPECT_TRUE(back_end.optimization_due());
  optimize(back_end);
  back_end.add_key_frame(drive.key_frames[401]);
  back_end.add_loop(make_loop(drive, 1, 401, engine));
  EXPECT_FALSE(back_end.optimization_due());
  for (std::size_t i = 402; i <= 410; ++i) back_end.add_key_frame(drive.key_frames[i]);
  EXPECT_TRUE(back_end.optimization_due());
}

TEST(Loops, ReportsAnEmptyGraph) {
  BackEnd back_end(BackEndConfig{});
  const auto solution = solve(*back_end.problem(true));
  EXPECT_FALSE(report_of(*solution).success);
  EXPECT_NE(report_of(*solution).message.find("no key frames"), std::string::npos);
  EXPECT_TRUE(back_end.apply(*solution).poses.empty());
}

TEST(Loops, PosesKeepIndexAndStampBitForBit) {
  SyntheticDrive drive = test::make_drive();
  for (std::size_t i = 0; i < drive.key_frames.size(); ++i) {
    drive.key_frames[i].index = static_cast<KeyFrameIndex>(3 * i + 7);
    drive.key_frames[i].stamp += static_cast<Stamp>(i % 7);
  }
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  const std::uint32_t revision = back_end.poses().revision;
  optimize(back_end);
  const KeyFramePoses poses = back_end.poses();
  EXPECT_EQ(poses.revision, revision + 1);
  ASSERT_EQ(poses.poses.size(), drive.key_frames.size());
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    EXPECT_EQ(poses.poses[i].index, drive.key_frames[i].index);
    EXPECT_EQ(poses.poses[i].stamp, drive.key_frames[i].stamp);
  }
}

// The data in a session are sufficient to continue: the same inputs give the same poses.
TEST(Loops, ReplayingTheInputsGivesTheSameBytes) {
  const SyntheticDrive drive = test::make_drive();
  const auto run = [&] {
    BackEnd back_end(BackEndConfig{});
    feed(back_end, drive);
    std::mt19937 engine(5);
    add_lap_loops(back_end, drive, 400, 7, engine);
    optimize(back_end);
    return back_end.poses().poses;
  };
  const auto a = run();
  const auto b = run();
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].T_map_base.translation, b[i].T_map_base.translation);
    EXPECT_EQ(a[i].T_map_base.rotation.coeffs(), b[i].T_map_base.rotation.coeffs());
  }
}

/// Tracking was lost at key frame 500; the front end starts a new segment at another pose.
SyntheticDrive drive_in_two_segments() {
  SyntheticDrive drive = test::make_drive();
  const Pose jump = {exp_so3({0.0, 0.0, 1.0}), {70.0, -30.0, 5.0}};
  for (std::size_t i = 500; i < 800; ++i) {
    drive.key_frames[i].segment = 1;
    drive.key_frames[i].T_odom_base = jump * drive.key_frames[i].T_odom_base;
  }
  return drive;
}

TEST(Segments, AreConnectedByLoopsAndNotByOdometry) {
  const SyntheticDrive drive = drive_in_two_segments();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  optimize(back_end);
  const auto apart = back_end.poses().poses;
  EXPECT_TRUE(test::near(apart[799].T_map_base.translation,
                         drive.key_frames[799].T_odom_base.translation, 1e-6))
      << "a segment that nothing ties keeps its odometry";
  std::mt19937 engine(5);
  for (int i = 400; i < 800; i += 5) back_end.add_loop(make_loop(drive, i - 400, i, engine));
  EXPECT_EQ(optimize(back_end).loops_refused, 0U);
  EXPECT_LT(aligned_rmse(back_end, drive), 0.3);
}

TEST(Segments, AreAlignedToEastNorthUpSeparately) {
  const SyntheticDrive drive = drive_in_two_segments();
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(5);
  for (int i = 0; i < 800; ++i) back_end.add_gnss(test::make_gnss(drive, i, engine, 0.02));
  optimize(back_end);
  EXPECT_LT(test::true_rmse(back_end, drive), 0.15);
}

TEST(Loops, NoFalseLoopIsUsedInSeveralDrives) {
  for (const unsigned seed : {1U, 3U, 5U}) {
    DriveSettings settings;
    settings.seed = seed;
    settings.turn_bias_deg = 0.005 * seed;
    const SyntheticDrive drive = test::make_drive(settings);
    BackEnd back_end(BackEndConfig{});
    feed(back_end, drive);
    std::mt19937 engine(seed);
    add_lap_loops(back_end, drive, 400, 10, engine);
    add_false_loops(back_end, drive, 4, engine);
    optimize(back_end, true);
    EXPECT_EQ(used_count(back_end, 0, 40), 40U) << "seed " << seed;
    EXPECT_EQ(used_count(back_end, 40, 80), 0U) << "seed " << seed;
  }
}

}  // namespace
}  // namespace lidar_mapping::back_end
