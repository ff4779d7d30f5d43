// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/session/map_datum.hpp"

#include "file_content.hpp"
#include "full_disk.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using session::Session;
using test::TemporaryFolder;

constexpr KeyFrameIndex kKeyFrames = 60;
constexpr double kStep = 2.0;

/// On a circle, so that the last key frame is where the first was.
Pose true_pose(KeyFrameIndex index) {
  const double angle = 2.0 * M_PI * index / (kKeyFrames - 1);
  const double radius = kStep * (kKeyFrames - 1) / (2.0 * M_PI);
  return {exp_so3({0.0, 0.0, angle}),
          {radius * std::sin(angle), radius * (1.0 - std::cos(angle)), 0.0}};
}

/// Odometry whose rotations are a little too large.
KeyFrame drifting_key_frame(KeyFrameIndex index) {
  KeyFrame key_frame;
  key_frame.index = index;
  key_frame.stamp = 1'000'000'000 + Stamp{index} * 200'000'000;
  key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
  Pose pose;
  for (KeyFrameIndex i = 1; i <= index; ++i) {
    const Pose motion = true_pose(i - 1).inverse() * true_pose(i);
    pose = pose * motion * Pose{exp_so3({0.0, 0.0, 0.0004}), Eigen::Vector3d::Zero()};
  }
  key_frame.T_odom_base = pose;
  auto cloud = std::make_shared<PointCloud>();
  cloud->points = {{1.0F, 2.0F, 3.0F, 4.0F}};
  key_frame.cloud = cloud;
  return key_frame;
}

Loop closing_loop() {
  Loop loop;
  loop.from = 0;
  loop.to = kKeyFrames - 1;
  loop.stamp = drifting_key_frame(loop.to).stamp;
  loop.T_from_to = true_pose(loop.from).inverse() * true_pose(loop.to);
  loop.covariance = diagonal_covariance(0.02, 0.002);
  loop.overlap = 0.9;
  return loop;
}

/// Between two sides of the circle, which are not at the same place.
Loop contradicting_loop() {
  Loop loop = closing_loop();
  loop.from = 10;
  loop.to = 40;
  loop.stamp = drifting_key_frame(loop.to).stamp;
  loop.T_from_to = Pose();
  return loop;
}

void drive(RecordedBackEnd& back_end, KeyFrameIndex begin, KeyFrameIndex end) {
  for (KeyFrameIndex index = begin; index < end; ++index) {
    back_end.add_key_frame(drifting_key_frame(index));
  }
}

/// A drive with GNSS at each key frame.
void drive_with_gnss(RecordedBackEnd& back_end, KeyFrameIndex key_frames) {
  back_end.set_datum({49.0, 8.4, 110.0});
  drive(back_end, 0, key_frames);
  for (KeyFrameIndex index = 0; index < key_frames; ++index) {
    GnssPosition position;
    position.stamp = drifting_key_frame(index).stamp;
    position.p_enu_antenna = true_pose(index).translation + Eigen::Vector3d(100.0, 50.0, 3.0);
    position.covariance = 0.01 * Eigen::Matrix3d::Identity();
    back_end.add_gnss(position);
  }
}

AppliedSolution optimize(RecordedBackEnd& back_end) {
  return back_end.apply(*back_end::solve(*back_end.problem(true)), 0.5);
}

Session reopened(const TemporaryFolder& folder) {
  return Session::open(folder.path(), Session::Access::kWrite);
}

TEST(RecordedBackEnd, StoresResultOfOptimization) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  ASSERT_TRUE(back_end.add_loop(closing_loop()));
  const AppliedSolution applied = optimize(back_end);
  EXPECT_TRUE(
      test::near(applied.poses.poses.back().T_map_base.translation, Eigen::Vector3d::Zero(), 0.1));
  ASSERT_EQ(applied.verdicts.size(), 1U);
  EXPECT_EQ(applied.verdicts[0].verdict, Verdict::kAccepted);
  EXPECT_EQ(back_end.session().poses().revision, applied.poses.revision);
  EXPECT_EQ(back_end.session().revisions().back().loops_used, 1U);
  EXPECT_TRUE(optimize(back_end).verdicts.empty()) << "an opinion is said once";
}

// Loops with unknown indices do not change session and graph.
TEST(RecordedBackEnd, RejectsLoopsWithUnknownOrEqualIndices) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, 5);
  Loop loop = closing_loop();
  EXPECT_FALSE(back_end.add_loop(loop));
  loop.to = loop.from;
  EXPECT_FALSE(back_end.add_loop(loop));
  EXPECT_TRUE(back_end.session().loops().empty());
}

// A resumed session gives the result of an uninterrupted run.
TEST(RecordedBackEnd, ResumedSessionEqualsUninterruptedOne) {
  const TemporaryFolder uninterrupted_folder;
  RecordedBackEnd uninterrupted(Session::create_in(uninterrupted_folder.path()), {});
  drive(uninterrupted, 0, kKeyFrames);
  uninterrupted.add_loop(closing_loop());
  const KeyFramePoses expected = optimize(uninterrupted).poses;

  const TemporaryFolder folder;
  std::uint32_t revision = 0;
  {
    RecordedBackEnd first(Session::create_in(folder.path()), {});
    drive(first, 0, 30);
    revision = optimize(first).poses.revision;
  }
  RecordedBackEnd second(reopened(folder), {});
  EXPECT_EQ(second.poses().poses.size(), 30U);
  drive(second, 30, kKeyFrames);
  second.add_loop(closing_loop());
  const KeyFramePoses poses = optimize(second).poses;
  EXPECT_GT(poses.revision, revision) << "revisions count on";
  EXPECT_EQ(second.session().poses().revision, poses.revision);
  ASSERT_EQ(poses.poses.size(), expected.poses.size());
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    EXPECT_TRUE(test::near(poses.poses[i].T_map_base.translation,
                           expected.poses[i].T_map_base.translation, 0.02))
        << "key frame " << i;
  }
}

AppliedSolution optimize_often(RecordedBackEnd& back_end) {
  return back_end.apply(*back_end::solve(*back_end.problem(true)), 0.5, PoseStorage::kWhenGrown);
}

TEST(RecordedBackEnd, StoresPosesOfManySolutionsAsTheDriveGrows) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  std::vector<std::uint32_t> stored;
  for (KeyFrameIndex index = 0; index < kKeyFrames; ++index) {
    drive(back_end, index, index + 1);
    optimize_often(back_end);
    const std::uint32_t revision = back_end.session().poses().revision;
    if (stored.empty() || stored.back() != revision) stored.push_back(revision);
  }
  EXPECT_EQ(stored, (std::vector<std::uint32_t>{0, 20, 41}));
  EXPECT_EQ(back_end.session().revisions().size(), kKeyFrames) << "figures of each";
  back_end.write_files();
  EXPECT_EQ(back_end.session().poses().poses.size(), kKeyFrames) << "and all of them at the end";
}

// Subscribers take poses with a number below the last one for outdated.
TEST(RecordedBackEnd, RevisionsCountOnFromOneWhosePosesWereNotStored) {
  const TemporaryFolder folder;
  std::uint32_t revision = 0;
  {
    RecordedBackEnd first(Session::create_in(folder.path()), {});
    drive(first, 0, 5);
    optimize_often(first);
    revision = optimize_often(first).poses.revision;
    EXPECT_LT(first.session().poses().revision, revision);
  }
  RecordedBackEnd second(reopened(folder), {});
  EXPECT_GT(optimize_often(second).poses.revision, revision);
}

// As a node that is started again and ended before anything else arrives.
TEST(RecordedBackEnd, StoresTheSolutionWithWhichItWasOpened) {
  const TemporaryFolder folder;
  {
    RecordedBackEnd first(Session::create_in(folder.path()), {});
    drive(first, 0, 10);
  }
  {
    RecordedBackEnd second(reopened(folder), {});
    EXPECT_TRUE(second.opening_report().success);
    ASSERT_EQ(second.session().revisions().size(), 1U);
    EXPECT_EQ(second.session().revisions()[0].cost_before, second.opening_report().cost_before);
    second.write_files();
    EXPECT_EQ(second.session().poses().poses.size(), 10U);
    EXPECT_EQ(second.session().poses().revision, second.poses().revision);
    drive(second, 10, kKeyFrames);
  }
  RecordedBackEnd third(reopened(folder), {});
  EXPECT_EQ(third.session().poses().poses.size(), kKeyFrames) << "at once: they are many more";
}

// Who makes a map of the poses of a node asks the session in which frame they lie.
TEST(RecordedBackEnd, StoresAtOnceThatTheOpenedSessionLiesElsewhere) {
  const TemporaryFolder folder;
  {
    RecordedBackEnd first(Session::create_in(folder.path()), {});
    drive_with_gnss(first, kKeyFrames);
    optimize(first);
    EXPECT_EQ(first.session().poses_in_enu(), true);
  }
  back_end::BackEndConfig without_gnss;
  without_gnss.use_gnss = false;
  const RecordedBackEnd second(reopened(folder), without_gnss);
  EXPECT_EQ(second.session().poses_in_enu(), false);
}

TEST(RecordedBackEnd, RestoresLoopsAfterRestart) {
  const TemporaryFolder folder;
  {
    RecordedBackEnd back_end(Session::create_in(folder.path()), {});
    drive(back_end, 0, kKeyFrames);
    back_end.add_loop(closing_loop());
  }
  RecordedBackEnd back_end(reopened(folder), {});
  ASSERT_EQ(back_end.verdicts().size(), 1U);
  EXPECT_EQ(back_end.verdicts()[0].verdict, Verdict::kAccepted);
  EXPECT_TRUE(test::near(back_end.poses().poses.back().T_map_base.translation,
                         Eigen::Vector3d::Zero(), 0.1));
  EXPECT_THROW(back_end.add_key_frame(drifting_key_frame(3)), InputError);
}

/// Loops arrive again after a restart of loop_closing_node or of the back end.
TEST(RecordedBackEnd, RecognizesKnownLoopsAlsoAfterRestart) {
  const TemporaryFolder folder;
  Loop corrected = closing_loop();
  corrected.source = LoopSource::kManual;
  corrected.T_from_to.translation.x() += 0.1;
  Loop reversed = closing_loop();
  std::swap(reversed.from, reversed.to);
  const auto expect_known = [&](const RecordedBackEnd& back_end) {
    EXPECT_TRUE(back_end.has_loop(closing_loop()));
    EXPECT_FALSE(back_end.has_loop(corrected)) << "a person gives another pose";
    EXPECT_FALSE(back_end.has_loop(reversed));
  };
  {
    RecordedBackEnd back_end(Session::create_in(folder.path()), {});
    drive(back_end, 0, kKeyFrames);
    EXPECT_FALSE(back_end.has_loop(closing_loop()));
    ASSERT_TRUE(back_end.add_loop(closing_loop()));
    expect_known(back_end);
  }
  RecordedBackEnd back_end(reopened(folder), {});
  expect_known(back_end);
  ASSERT_TRUE(back_end.add_loop(corrected));
  EXPECT_TRUE(back_end.has_loop(corrected));
}

/// The verdicts of the search on these loops, before any solution.
constexpr const char* kFound = "the search found it";

/// A session with these loops as a drive leaves it that ends before a solution.
void store_drive(const TemporaryFolder& folder, const std::vector<Loop>& loops) {
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  for (const Loop& loop : loops) {
    ASSERT_TRUE(back_end.add_loop(loop));
    back_end.add_verdict(verdict_on(loop, Verdict::kAccepted, kFound));
  }
}

LoopVerdict stored_verdict(const RecordedBackEnd& back_end, const Loop& loop) {
  return newest_verdicts(back_end.session().verdicts()).at({loop.from, loop.to});
}

/// Solves the session once more and returns its list of loops.
std::string list_after_solution(RecordedBackEnd& back_end) {
  optimize(back_end);
  back_end.write_files();
  return test::content_of(back_end.session().directory() / "loops.csv");
}

TEST(RecordedBackEnd, StoresTheVerdictsOfTheFirstSolutionAfterARestart) {
  const TemporaryFolder folder;
  store_drive(folder, {closing_loop(), contradicting_loop()});
  {
    RecordedBackEnd back_end(reopened(folder), {});
    const std::string list = list_after_solution(back_end);
    EXPECT_EQ(stored_verdict(back_end, closing_loop()).verdict, Verdict::kAccepted);
    EXPECT_EQ(stored_verdict(back_end, closing_loop()).reason, "the graph agrees with it");
    EXPECT_EQ(stored_verdict(back_end, contradicting_loop()).verdict, Verdict::kRefused);
    EXPECT_NE(list.find("refused,\"the graph leaves it out"), std::string::npos) << list;
  }
  RecordedBackEnd back_end(reopened(folder), {});
  EXPECT_TRUE(optimize(back_end).verdicts.empty()) << "an opinion is said once";
}

TEST(RecordedBackEnd, StoresWhatAPersonDecidedBeforeARestart) {
  const TemporaryFolder folder;
  store_drive(folder, {closing_loop()});
  const Loop loop = closing_loop();
  const auto solve_with = [&](LoopDecision decision) {
    reopened(folder).set_loop_decision(loop.from, loop.to, decision);
    RecordedBackEnd back_end(reopened(folder), {});
    EXPECT_NE(list_after_solution(back_end).find("a person"), std::string::npos);
    return stored_verdict(back_end, loop);
  };
  const LoopVerdict accepted = solve_with(LoopDecision::kAccept);
  EXPECT_EQ(accepted.verdict, Verdict::kAccepted);
  EXPECT_EQ(accepted.reason, "a person accepted it");
  const LoopVerdict refused = solve_with(LoopDecision::kRefuse);
  EXPECT_EQ(refused.verdict, Verdict::kRefused);
  EXPECT_EQ(refused.reason, "a person refused it");
}

// After a restart key frames are searched again.
TEST(RecordedBackEnd, TheVerdictOfTheGraphPrevailsOverThatOfALaterSearch) {
  const TemporaryFolder folder;
  store_drive(folder, {closing_loop(), contradicting_loop()});
  RecordedBackEnd back_end(reopened(folder), {});
  optimize(back_end);
  back_end.add_verdict(verdict_on(contradicting_loop(), Verdict::kAccepted, kFound));
  optimize(back_end);
  EXPECT_EQ(stored_verdict(back_end, contradicting_loop()).verdict, Verdict::kRefused);
}

// The graph holds both, the session the newer one.
TEST(RecordedBackEnd, ACorrectedLoopHasOneVerdict) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  Loop wrong = closing_loop();
  wrong.T_from_to.translation.x() += 20.0;
  ASSERT_TRUE(back_end.add_loop(wrong));
  Loop corrected = closing_loop();
  corrected.source = LoopSource::kManual;
  corrected.decision = LoopDecision::kAccept;
  ASSERT_TRUE(back_end.add_loop(corrected));
  EXPECT_EQ(optimize(back_end).verdicts.size(), 1U);
  EXPECT_EQ(stored_verdict(back_end, corrected).reason, "a person accepted it");
  EXPECT_TRUE(optimize(back_end).verdicts.empty());
}

TEST(RecordedBackEnd, RefusesAllLoopsWhereLoopsAreNotUsed) {
  const TemporaryFolder folder;
  store_drive(folder, {closing_loop()});
  reopened(folder).set_loop_decision(0, kKeyFrames - 1, LoopDecision::kAccept);
  back_end::BackEndConfig config;
  config.use_loop_close = false;
  RecordedBackEnd back_end(reopened(folder), config);
  optimize(back_end);
  EXPECT_EQ(stored_verdict(back_end, closing_loop()).verdict, Verdict::kRefused);
  EXPECT_EQ(stored_verdict(back_end, closing_loop()).reason, "loops are not used (use_loop_close)");
}

TEST(RecordedBackEnd, FollowsASolutionThatTheSessionCannotStore) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  ASSERT_TRUE(back_end.add_loop(closing_loop()));
  const auto solution = back_end::solve(*back_end.problem(true));
  AppliedSolution applied;
  {
    const test::FullDisk full;
    applied = back_end.apply(*solution, 0.5);
  }
  EXPECT_NE(applied.storing_failure, "");
  EXPECT_EQ(applied.verdicts.size(), 1U);
  EXPECT_TRUE(
      test::near(applied.poses.poses.back().T_map_base.translation, Eigen::Vector3d::Zero(), 0.1));
  EXPECT_TRUE(back_end.session().poses().poses.empty());
  EXPECT_TRUE(back_end.session().verdicts().empty());
  back_end.write_files();
  EXPECT_EQ(back_end.session().poses().revision, applied.poses.revision);
  EXPECT_EQ(back_end.session().revisions().back().seconds, 0.5);
  EXPECT_EQ(stored_verdict(back_end, closing_loop()).reason, "the graph agrees with it");
  EXPECT_EQ(optimize(back_end).storing_failure, "");
}

TEST(RecordedBackEnd, TakesNoLoopThatTheSessionCannotStore) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  bool has_failed = false;
  try {
    const test::FullDisk full;
    back_end.add_loop(closing_loop());
  } catch (const FileError&) {
    has_failed = true;
  }
  EXPECT_TRUE(has_failed);
  EXPECT_TRUE(back_end.verdicts().empty()) << "the graph is as before";
  EXPECT_FALSE(back_end.has_loop(closing_loop()));
  EXPECT_TRUE(back_end.add_loop(closing_loop()));
}

// A finished session that a new drive extends keeps its frame.
TEST(RecordedBackEnd, TransformsPositionsToDatumOfSession) {
  const TemporaryFolder folder;
  const GeodeticDatum old_datum{49.0, 8.4, 110.0};
  const GeodeticDatum new_datum{49.001, 8.4, 100.0};  // 111 m north, 10 m below
  {
    RecordedBackEnd back_end(Session::create_in(folder.path()), {});
    back_end.set_datum(old_datum);
    drive(back_end, 0, 5);
  }
  RecordedBackEnd back_end(reopened(folder), {});
  back_end.set_datum(new_datum);
  GnssPosition position;
  position.stamp = 1;
  position.p_enu_antenna = {3.0, 0.0, 1.0};
  back_end.add_gnss(position);
  EXPECT_EQ(back_end.session().datum(), old_datum);
  const Eigen::Vector3d p = back_end.session().gnss().at(0).p_enu_antenna;
  EXPECT_TRUE(test::near(p, Eigen::Vector3d(3.0, 111.2, -9.0), 0.1)) << p.transpose();
}

/// Seen from 100 km away the vertical leans by 0.9 degrees: 10 km of an unknown height would be
/// 157 m of an unknown position.
TEST(RecordedBackEnd, KeepsPositionsWithoutHeightThroughAChangeOfTheDatum) {
  const TemporaryFolder folder;
  {
    RecordedBackEnd back_end(Session::create_in(folder.path()), {});
    back_end.set_datum({49.0, 8.4, 110.0});
    drive(back_end, 0, 5);
  }
  RecordedBackEnd back_end(reopened(folder), {});
  back_end.set_datum({49.9, 8.4, 110.0});
  GnssPosition position;
  position.stamp = 1;
  position.covariance(2, 2) = kUnknownHeightStddev * kUnknownHeightStddev;
  back_end.add_gnss(position);
  const GnssPosition stored = back_end.session().gnss().at(0);
  EXPECT_FALSE(has_height(stored.covariance));
  EXPECT_LT(stored.covariance(0, 0) + stored.covariance(1, 1), 2.01);
}

/// Whether the session tells where on Earth its map lies, after a drive with GNSS.
bool is_georeferenced(const back_end::BackEndConfig& config, KeyFrameIndex key_frames,
                      PoseStorage storage = PoseStorage::kAlways) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), config);
  drive_with_gnss(back_end, key_frames);
  EXPECT_FALSE(session::map_datum(back_end.session()));
  back_end.apply(*back_end::solve(*back_end.problem(true)), 0.5, storage);
  EXPECT_TRUE(back_end.session().datum());
  return session::map_datum(back_end.session()).has_value();
}

TEST(RecordedBackEnd, MapLiesInEastNorthUpOnlyIfItWasTurnedToIt) {
  EXPECT_TRUE(is_georeferenced({}, kKeyFrames));
  EXPECT_TRUE(is_georeferenced({}, 15, PoseStorage::kWhenGrown)) << "these poses are not due yet";
  back_end::BackEndConfig without_gnss;
  without_gnss.use_gnss = false;
  EXPECT_FALSE(is_georeferenced(without_gnss, kKeyFrames));
  EXPECT_FALSE(is_georeferenced({}, 2)) << "3 m do not tell the heading";
}

TEST(RecordedBackEnd, WritesTrajectoriesLoopsAndGraph) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  back_end.add_loop(closing_loop());
  optimize(back_end);
  back_end.write_files();
  for (const char* name : {"trajectory/optimized.txt", "trajectory/laser_odom.tum", "loops.csv",
                           "candidates.csv", "graph.g2o"}) {
    EXPECT_GT(std::filesystem::file_size(folder.path() / name), 100U) << name;
  }
}

TEST(RecordedBackEnd, SearchesAgainWhereAMatchWaits) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  EXPECT_EQ(back_end.searched_key_frames(), 0U);
  drive(back_end, 0, 40);
  const auto decide = [&](KeyFrameIndex from, KeyFrameIndex to, Verdict decision,
                          const std::string& reason = "for the test") {
    Loop loop;
    loop.from = from;
    loop.to = to;
    back_end.add_verdict(verdict_on(loop, decision, reason));
  };
  decide(2, 15, Verdict::kUndecided, "nothing stands above the ground");
  EXPECT_EQ(back_end.searched_key_frames(), 16U) << "another search would say the same";
  decide(3, 25, Verdict::kUndecided, waiting_reason(30.0));
  decide(5, 30, Verdict::kRefused);
  EXPECT_EQ(back_end.searched_key_frames(), 25U) << "it is open yet";
  decide(3, 25, Verdict::kAccepted);
  EXPECT_EQ(back_end.searched_key_frames(), 31U);
}

TEST(RecordedBackEnd, StoresOnceWhatASearchSaysAgain) {
  const TemporaryFolder folder;
  const auto waiting = verdict_on(closing_loop(), Verdict::kUndecided, waiting_reason(30.0));
  const auto accepted = verdict_on(closing_loop(), Verdict::kAccepted, "another confirms it");
  for (int start = 0; start < 3; ++start) {
    const bool is_first = start == 0;
    RecordedBackEnd back_end(is_first ? Session::create_in(folder.path()) : reopened(folder), {});
    if (is_first) drive(back_end, 0, kKeyFrames);
    back_end.add_verdict(waiting);
    back_end.add_verdict(accepted);
    EXPECT_EQ(back_end.session().verdicts().size(), 2U);
    EXPECT_EQ(back_end.searched_key_frames(), kKeyFrames) << "the newest one is the last";
  }
}

TEST(RecordedBackEnd, StoresLaterWhatAFullDiskDidNotTake) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, kKeyFrames);
  const auto waiting = verdict_on(closing_loop(), Verdict::kUndecided, waiting_reason(30.0));
  {
    const test::FullDisk full;
    EXPECT_THROW(back_end.add_verdict(waiting), FileError);
  }
  back_end.add_verdict(waiting);
  EXPECT_EQ(back_end.session().verdicts().size(), 1U);
}

TEST(RecordedBackEnd, ReturnsTheWarningsThatItWrites) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  drive(back_end, 0, 20);
  EXPECT_TRUE(back_end.write_files().empty());
  KeyFrame apart = drifting_key_frame(20);
  apart.segment = 1;
  back_end.add_key_frame(apart);
  const std::vector<std::string> warnings_written = back_end.write_files();
  EXPECT_FALSE(warnings_written.empty());
  EXPECT_EQ(warnings_written, warnings(read_doubt(folder.path() / "doubt.csv")));
}

}  // namespace
}  // namespace lidar_mapping::pipeline
