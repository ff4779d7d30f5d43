// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>
#include <fstream>
#include <limits>
#include <set>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/session/map_datum.hpp"

#include "error_text.hpp"
#include "example_values.hpp"
#include "file_content.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::session {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::files_in;
using test::TemporaryFolder;

constexpr std::time_t kNow = 1'317'646'533;

// The stored state is complete.
TEST(Session, ReturnsKeyFramesBitForBit) {
  const TemporaryFolder folder;
  {
    Session session = Session::create_in(folder.path());
    for (const KeyFrameIndex index : {0U, 1U, 12U}) {
      session.add_key_frame(example_key_frame(index));
    }
  }
  const Session session = Session::open(folder.path(), Session::Access::kRead);
  const std::vector<KeyFrame> key_frames = session.key_frames();
  ASSERT_EQ(key_frames.size(), 3U);
  const KeyFrame expected = example_key_frame(12);
  EXPECT_EQ(key_frames[2].index, expected.index);
  EXPECT_EQ(key_frames[2].segment, expected.segment);
  EXPECT_EQ(key_frames[2].stamp, expected.stamp);
  expect_equal(key_frames[2].T_odom_base, expected.T_odom_base);
  EXPECT_EQ(key_frames[2].motion_covariance, expected.motion_covariance);
  ASSERT_EQ(key_frames[2].degenerate_directions.size(), 1U);
  EXPECT_EQ(key_frames[2].degenerate_directions[0], expected.degenerate_directions[0]);
  EXPECT_FALSE(key_frames[1].doubtful);
  EXPECT_TRUE(key_frames[2].doubtful);
  ASSERT_NE(session.clouds().cloud(12), nullptr);
  expect_equal(*session.clouds().cloud(12), *expected.cloud);
  ASSERT_TRUE(session.key_frame(12).has_value());
  EXPECT_EQ(session.key_frame(12)->stamp, expected.stamp);
  EXPECT_TRUE(session.key_frame(12)->doubtful);
  expect_equal(session.key_frame(12)->T_odom_base, expected.T_odom_base);
  EXPECT_FALSE(session.key_frame(11).has_value());
}

TEST(Session, ReturnsLoopsAndVerdicts) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  session.add_loop(example_loop(3, 200));
  session.add_loop(example_loop(4, 201));
  Loop better = example_loop(3, 200);
  better.fitness = 0.01;
  session.add_loop(better);
  LoopVerdict verdict;
  verdict.from = 3;
  verdict.to = 200;
  verdict.verdict = Verdict::kRefused;
  verdict.reason = "fitness 0.5 m^2 > fitness_score_limit 0.2 m^2";
  verdict.innovation = 7.5;
  session.add_verdict(verdict);

  const std::vector<Loop> loops = session.loops();
  ASSERT_EQ(loops.size(), 2U) << "a loop measured again replaces the older measurement";
  EXPECT_EQ(loops[1].fitness, 0.01);
  expect_equal(loops[0].T_from_to, example_loop(4, 201).T_from_to);
  EXPECT_EQ(loops[0].covariance, example_loop(4, 201).covariance);
  EXPECT_EQ(loops[0].source, LoopSource::kAppearance);
  ASSERT_EQ(session.verdicts().size(), 1U);
  EXPECT_EQ(session.verdicts()[0].reason, verdict.reason);
  EXPECT_EQ(session.verdicts()[0].verdict, Verdict::kRefused);
  EXPECT_EQ(session.verdicts()[0].innovation, 7.5);
}

TEST(Session, ReturnsMeasurementsAlsoWithoutOrientation) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  GnssPosition position;
  position.stamp = 5;
  position.p_enu_antenna = {4'649'776.123456789, -2.0, 3.0};
  position.covariance(0, 1) = 0.25;
  position.p_base_antenna = {0.1, 0.2, 1.5};
  session.add_gnss(position);
  position.stamp = 6;
  position.R_enu_base = exp_so3({0.1, 0.2, 0.3});
  session.add_gnss(position);
  ImuSample sample;
  sample.stamp = 7;
  sample.linear_acceleration = {0.0, 0.1, 9.81};
  session.add_imu(sample);
  Floor floor;
  floor.stamp = 8;
  floor.found = true;
  floor.offset = 1.73;
  floor.inliers = 2000;
  session.add_floor(floor);

  ASSERT_EQ(session.gnss().size(), 2U);
  EXPECT_EQ(session.gnss()[0].p_enu_antenna, position.p_enu_antenna);
  EXPECT_EQ(session.gnss()[0].covariance, position.covariance);
  EXPECT_EQ(session.gnss()[0].p_base_antenna, position.p_base_antenna);
  EXPECT_FALSE(session.gnss()[0].R_enu_base);
  ASSERT_TRUE(session.gnss()[1].R_enu_base);
  EXPECT_EQ(session.gnss()[1].R_enu_base->coeffs(), position.R_enu_base->coeffs());
  ASSERT_EQ(session.imu().size(), 1U);
  EXPECT_EQ(session.imu()[0].linear_acceleration, sample.linear_acceleration);
  EXPECT_FALSE(session.imu()[0].orientation);
  ASSERT_EQ(session.floors().size(), 1U);
  EXPECT_TRUE(session.floors()[0].found);
  EXPECT_EQ(session.floors()[0].offset, 1.73);
  EXPECT_EQ(session.floors()[0].inliers, 2000);
}

TEST(Session, ReturnsScansOdometryAndProperties) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  EXPECT_FALSE(session.datum());
  EXPECT_EQ(session.run_id(), "");
  session.set_run_id("run-7");
  EXPECT_FALSE(session.sensor_origin());
  session.set_sensor_origin({0.5, 0.0, 1.8});
  session.set_datum({48.123456789012, 11.5, 520.25});
  session.add_scan({9, "tracking", 0.1, 0.9, 0.05, 3, 0.0, 0.0, {}});
  session.add_odometry(9, example_key_frame(1).T_odom_base);
  session.set_configuration("back_end", "use_gnss: true\n# a sentence\nuse_loop_close: false\n");

  EXPECT_EQ(session.run_id(), "run-7");
  ASSERT_TRUE(session.sensor_origin());
  EXPECT_EQ(*session.sensor_origin(), Eigen::Vector3d(0.5, 0.0, 1.8));
  ASSERT_TRUE(session.datum());
  EXPECT_EQ(session.datum()->latitude_deg, 48.123456789012);
  ASSERT_EQ(session.scans().size(), 1U);
  EXPECT_EQ(session.scans()[0].state, "tracking");
  EXPECT_EQ(session.scans()[0].scans_dropped, 3);
  ASSERT_EQ(session.odometry().size(), 1U);
  EXPECT_EQ(session.odometry()[0].drive, 0U);
  expect_equal(session.odometry()[0].T_odom_base, example_key_frame(1).T_odom_base);
  session.add_odometry({11, example_key_frame(2).T_odom_base, 3});
  session.add_odometry(10, example_key_frame(2).T_odom_base);
  ASSERT_EQ(session.odometry().size(), 3U);
  EXPECT_EQ(session.odometry()[1].drive, 3U) << "who goes on adds to the newest drive";
  EXPECT_EQ(session.odometry()[2].drive, 3U);
  EXPECT_EQ(content_of(folder.path() / "config.yaml"),
            "back_end:\n  use_gnss: true\n  # a sentence\n  use_loop_close: false\n");
}

TEST(Session, KeepsTheNewestTenRevisionsOfPoses) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  EXPECT_EQ(session.poses().revision, 0U);
  EXPECT_TRUE(session.poses().poses.empty());
  for (std::uint32_t revision = 1; revision <= 15; ++revision) {
    KeyFramePoses poses;
    poses.revision = revision;
    Pose pose;
    pose.translation.x() = revision;
    poses.poses = {{0, 100, pose}, {1, 200, pose}};
    RevisionRecord record;
    record.revision = revision;
    record.cost_after = 0.5;
    session.set_poses(poses, record);
  }
  EXPECT_EQ(session.poses().revision, 15U);
  ASSERT_EQ(session.poses().poses.size(), 2U);
  EXPECT_EQ(session.poses().poses[1].stamp, 200);
  EXPECT_EQ(session.poses().poses[1].T_map_base.translation.x(), 15.0);
  EXPECT_EQ(session.revisions().size(), 15U);
}

TEST(Session, KnowsInWhichFrameTheNewestPosesLie) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  session.set_datum({48.0, 11.5, 520.0});
  KeyFramePoses poses;
  EXPECT_FALSE(map_datum(session)) << "there is no map yet";
  for (const std::optional<bool> in_enu : {std::optional(false), std::optional(true), {}}) {
    ++poses.revision;
    poses.poses = {{0, 100, Pose()}};
    RevisionRecord record;
    record.revision = poses.revision;
    session.set_poses(poses, record, in_enu);
    EXPECT_EQ(session.poses_in_enu(), in_enu);
    EXPECT_EQ(map_datum(session).has_value(), in_enu.value_or(true));
  }
  session.set_poses(poses, {}, false);
  session.set_configuration(kImportedMap, "");
  EXPECT_TRUE(map_datum(session)) << "needs no position of GNSS";
}

TEST(Session, RefusesAnIndexTwiceWithoutChange) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  session.add_key_frame(example_key_frame(3));
  KeyFrame other = example_key_frame(3);
  other.cloud = example_cloud(7, 99);
  EXPECT_THROW(session.add_key_frame(other), InputError);
  EXPECT_EQ(session.clouds().cloud(3)->size(), 100U);
}

// A reader takes such numbers for damage: one of them would make all of a drive unreadable.
TEST(Session, RefusesNumbersThatItCouldNotReadBack) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path());
  GnssPosition position;
  position.p_enu_antenna.z() = kNaN;
  EXPECT_THROW(session.add_gnss(position), InputError);
  position.p_enu_antenna.z() = 2e9;
  EXPECT_THROW(session.add_gnss(position), InputError);
  ImuSample sample;
  sample.orientation = Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0);
  EXPECT_THROW(session.add_imu(sample), InputError);
  Floor floor;
  floor.covariance(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(session.add_floor(floor), InputError);
  floor.covariance(1, 1) = 1.0;
  floor.offset = kNaN;
  EXPECT_THROW(session.add_floor(floor), InputError);
  KeyFrame key_frame = example_key_frame(3);
  key_frame.T_odom_base.translation.x() = kNaN;
  EXPECT_THROW(session.add_key_frame(key_frame), InputError);
  EXPECT_FALSE(session.clouds().contains(3));
  EXPECT_TRUE(session.gnss().empty() && session.imu().empty() && session.floors().empty());
  EXPECT_TRUE(session.key_frames().empty());
}

// A second start does not change the first run.
TEST(Session, TwoStartsUseSeparateFolders) {
  const TemporaryFolder root;
  fs::path first;
  {
    Session session = Session::create(root.path(), kNow);
    session.add_key_frame(example_key_frame(0));
    first = session.directory();
  }
  const auto before = files_in(first);
  const Session second = Session::create(root.path(), kNow);
  EXPECT_NE(second.directory(), first);
  EXPECT_EQ(files_in(first), before);
  EXPECT_EQ(find_session(root.path()), fs::canonical(second.directory()));
}

// Files of other programs are kept, also one with the name of the link.
TEST(Session, DoesNotTouchOtherFiles) {
  const TemporaryFolder root;
  std::ofstream(root.path() / "latest") << "not a link";
  fs::create_directories(root.path() / "key_frames");
  std::ofstream(root.path() / "key_frames" / "000000.pcd") << "mine";
  const Session session = Session::create(root.path(), kNow);
  EXPECT_EQ(content_of(root.path() / "latest"), "not a link");
  EXPECT_EQ(content_of(root.path() / "key_frames" / "000000.pcd"), "mine");
  EXPECT_THROW(Session::create_in(session.directory()), FileError);
}

// Missing parent folders are created.
TEST(Session, CreatesMissingParents) {
  const TemporaryFolder root;
  const Session session = Session::create(root.path() / "a" / "b", kNow);
  EXPECT_TRUE(fs::exists(session.directory() / "session.db"));
}

TEST(Session, RefusesASecondWriterAndAllowsReaders) {
  const TemporaryFolder folder;
  Session writer = Session::create_in(folder.path());
  EXPECT_THROW(Session::open(folder.path(), Session::Access::kWrite), FileError);
  writer.add_key_frame(example_key_frame(0));
  const Session reader = Session::open(folder.path(), Session::Access::kRead);
  EXPECT_EQ(reader.key_frame_count(), 1U);
  writer.add_key_frame(example_key_frame(1));
  EXPECT_EQ(reader.key_frame_count(), 2U);
}

TEST(Session, ContinuesAfterItWasReopened) {
  const TemporaryFolder folder;
  Session::create_in(folder.path()).add_key_frame(example_key_frame(0));
  Session::open(folder.path(), Session::Access::kWrite).add_key_frame(example_key_frame(1));
  EXPECT_EQ(Session::open(folder.path(), Session::Access::kRead).key_frame_count(), 2U);
}

// A process that is killed in its first milliseconds leaves a database without tables.
TEST(Session, ContinuesAfterAKillBeforeTheTablesWereCreated) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "session.db").close();
  Session::open(folder.path(), Session::Access::kWrite).add_key_frame(example_key_frame(0));
  EXPECT_EQ(Session::open(folder.path(), Session::Access::kRead).key_frame_count(), 1U);
}

// Incomplete sessions are refused with a message.
TEST(Session, ReportsWhyAFolderIsNotASession) {
  const TemporaryFolder folder;
  EXPECT_THROW(Session::open(folder.path(), Session::Access::kRead), FileError);
  std::ofstream(folder.path() / "session.db") << std::string(5000, 'x');
  EXPECT_THROW(Session::open(folder.path(), Session::Access::kRead), FileError);
  fs::resize_file(folder.path() / "session.db", 0);
  EXPECT_THROW(Session::open(folder.path(), Session::Access::kRead), FileError);
}

TEST(Session, RefusesAFolderThatCannotBeCreated) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  EXPECT_THROW(Session::create(folder.path() / "file" / "root", kNow), FileError);
}

/// Adds key frames until it is killed; the parent is informed of each by one byte.
[[noreturn]] void write_until_killed(const fs::path& folder, int pipe_end) {
  Session session = Session::create_in(folder);
  for (KeyFrameIndex index = 0;; ++index) {
    session.add_key_frame(example_key_frame(index));
    session.add_loop(example_loop(0, index + 1));
    if (::write(pipe_end, "k", 1) != 1) _exit(1);
  }
}

// What was reported as stored is complete, whenever the process is killed.
TEST(Session, SurvivesKillAtAnyMoment) {
  for (int round = 1; round <= 6; ++round) {
    const TemporaryFolder folder;
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) write_until_killed(folder.path(), ends[1]);
    char byte;
    const int wanted = 3 * round;
    for (int received = 0; received < wanted; ++received) ASSERT_EQ(::read(ends[0], &byte, 1), 1);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ::close(ends[0]);
    ::close(ends[1]);

    Session session = Session::open(folder.path(), Session::Access::kWrite);
    const std::vector<KeyFrame> key_frames = session.key_frames();
    ASSERT_GE(key_frames.size(), static_cast<std::size_t>(wanted));
    for (std::size_t i = 0; i < key_frames.size(); ++i) {
      EXPECT_EQ(key_frames[i].index, i);
      const PointCloudPtr cloud = session.clouds().cloud(key_frames[i].index);
      ASSERT_NE(cloud, nullptr);
      EXPECT_EQ(cloud->size(), 100U);
    }
    session.add_key_frame(example_key_frame(static_cast<KeyFrameIndex>(key_frames.size())));
  }
}

/// Exit status 0 if a session on a full disk refuses what does not fit and keeps the rest.
int write_to_a_full_disk(const fs::path& folder) {
  ::signal(SIGXFSZ, SIG_IGN);
  // Bytes per file: the database reaches the limit, the clouds do not.
  const rlimit limit{200'000, 200'000};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  Session session = Session::create_in(folder);
  std::size_t stored = 0;
  for (KeyFrameIndex index = 0; index < 500; ++index) {
    try {
      session.add_key_frame(example_key_frame(index));
      ++stored;
    } catch (const FileError&) {
      return stored > 10 && session.key_frame_count() == stored ? 0 : 2;
    }
  }
  return 1;
}

// A full disk gives an error, and the data stored before stay complete.
TEST(Session, RefusesDataThatDoNotFitOnTheDisk) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(write_to_a_full_disk(folder.path()));
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const Session session = Session::open(folder.path(), Session::Access::kRead);
  EXPECT_GT(session.key_frame_count(), 10U);
  for (const KeyFrame& key_frame : session.key_frames()) {
    EXPECT_NE(session.clouds().cloud(key_frame.index), nullptr);
  }
}

void read_whole(const fs::path& folder) {
  const Session session = Session::open(folder, Session::Access::kRead);
  session.key_frames();
  session.loops();
  session.poses();
  session.datum();
}

// SQLite stores any type in any column, and its pages have no checksums.
TEST(Session, ReportsFileAndColumnOfADamagedCell) {
  const std::pair<const char*, const char*> kDamages[] = {
      {"UPDATE key_frames SET x = 9e999", "as x"},
      {"UPDATE key_frames SET x = NULL", "as x"},
      {"UPDATE key_frames SET y = 'nan'", "as y"},
      {"UPDATE key_frames SET qx = 3.0", "as qx"},
      {"UPDATE key_frames SET stamp = 9223372036854775807", "as stamp"},
      {"UPDATE key_frames SET segment = -1", "as segment"},
      {"UPDATE key_frames SET motion_covariance = x'00112233'", "as motion_covariance"},
      {"UPDATE key_frames SET motion_covariance = zeroblob(72)", "36 numbers"},
      {"UPDATE key_frames SET degenerate_directions = x'ffffffffffffffff'", "finite numbers"},
      {"UPDATE loops SET source = 'rumour'", "as source"},
      {"INSERT INTO properties VALUES ('datum', zeroblob(16))", "3 numbers"},
      {"INSERT INTO properties VALUES ('datum', x'0000000000c05840"
       "00000000000000000000000000000000')",
       "no place on Earth"}};
  for (const auto& [sql, expected] : kDamages) {
    const TemporaryFolder folder;
    {
      Session session = Session::create_in(folder.path());
      session.add_key_frame(example_key_frame(0));
      session.add_loop(example_loop(0, 5));
    }
    EXPECT_NO_THROW(read_whole(folder.path()));
    execute(folder.path(), sql);
    const std::string text = test::error_text<FileError>([&] { read_whole(folder.path()); });
    EXPECT_NE(text.find("session.db"), std::string::npos) << sql << ": " << text;
    EXPECT_NE(text.find(expected), std::string::npos) << sql << ": " << text;
  }
}

}  // namespace
}  // namespace lidar_mapping::session
