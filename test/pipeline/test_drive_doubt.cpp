// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using session::Session;
using test::TemporaryFolder;

constexpr double kSpeed = 10.0;        // m/s
constexpr double kPeriod = 0.1;        // s
constexpr KeyFrameIndex kScans = 400;  // every second one is a key frame

Stamp stamp_of(KeyFrameIndex scan) { return from_seconds(1000.0 + kPeriod * scan); }

Eigen::Vector3d place_of(KeyFrameIndex scan) { return {kSpeed * kPeriod * scan, 0.0, 0.0}; }

/// A drive straight on whose scans have these states, with a way that is unobserved by so much.
struct StraightDrive {
  std::string (*state)(KeyFrameIndex) = [](KeyFrameIndex) { return std::string("tracking"); };
  double (*unobserved)(KeyFrameIndex) = [](KeyFrameIndex) { return 0.0; };
  double degraded_sigma = 0.003;        ///< m, of a step to a degraded scan
  KeyFrameIndex segment_from = kScans;  ///< a new segment of the trajectory begins there

  void write(RecordedBackEnd& run) const {
    for (KeyFrameIndex scan = 0; scan < kScans; ++scan) {
      session::ScanRecord record;
      record.stamp = stamp_of(scan);
      record.state = state(scan);
      record.unobserved_stddev = unobserved(scan);
      record.probability = record.state == "degraded" ? 0.2 : 0.99;
      run.session().add_scan(record);
      run.session().add_odometry(record.stamp, {Eigen::Quaterniond::Identity(), place_of(scan)});
      if (scan % 2 != 0 || record.state == "lost") continue;
      KeyFrame key_frame;
      key_frame.index = scan / 2;
      key_frame.segment = scan < segment_from ? 0 : 1;
      key_frame.stamp = record.stamp;
      key_frame.T_odom_base.translation = place_of(scan);
      key_frame.motion_covariance = diagonal_covariance(0.003, 0.0002);
      if (record.state == "degraded") {
        key_frame.motion_covariance = diagonal_covariance(degraded_sigma, 0.0002);
      }
      if (record.state == "doubtful") {
        key_frame.motion_covariance = diagonal_covariance(0.003, 0.01);
        key_frame.doubtful = true;
      }
      if (record.state == "degenerate") {
        key_frame.degenerate_directions = {Eigen::Vector3d::UnitX()};
      }
      run.add_key_frame(key_frame);
    }
  }
};

Loop loop_between(KeyFrameIndex from, KeyFrameIndex to) {
  Loop loop;
  loop.from = from;
  loop.to = to;
  loop.T_from_to.translation = place_of(2 * to) - place_of(2 * from);
  loop.covariance = diagonal_covariance(0.02, 0.002);
  loop.overlap = 0.9;
  return loop;
}

/// doubt.csv of the drive with these loops.
DriveDoubt doubt_of(const StraightDrive& drive, const std::vector<Loop>& loops = {}) {
  const TemporaryFolder folder;
  RecordedBackEnd run(Session::create_in(folder.path()), {});
  drive.write(run);
  for (const Loop& loop : loops) run.add_loop(loop);
  run.apply(*back_end::solve(*run.problem(true)), 0.0);
  run.write_files();
  return read_doubt(folder.path() / "doubt.csv");
}

bool in_tunnel(KeyFrameIndex scan) { return scan >= 100 && scan < 300; }

/// 200 m at whose end the way is off by 10 m.
StraightDrive tunnel() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(in_tunnel(scan) ? "degenerate" : "tracking");
  };
  drive.unobserved = [](KeyFrameIndex scan) {
    return scan < 100 ? 0.0 : 10.0 * std::min(1.0, (scan - 99.0) / 200.0);
  };
  return drive;
}

TEST(DriveDoubt, SaysNothingOfACleanDrive) {
  const DriveDoubt doubt = doubt_of({});
  EXPECT_TRUE(doubt.is_trusted());
  EXPECT_TRUE(doubt.stretches.empty());
  EXPECT_TRUE(warnings(doubt).empty());
  EXPECT_EQ(remark(doubt), "");
}

TEST(DriveDoubt, DoesNotTrustAWayThatNothingObserved) {
  const DriveDoubt doubt = doubt_of(tunnel());
  ASSERT_EQ(doubt.stretches.size(), 1U);
  const DoubtfulStretch& stretch = doubt.stretches.front();
  EXPECT_EQ(stretch.doubt, Doubt::kDegenerate);
  EXPECT_EQ(stretch.begin, stamp_of(100));
  EXPECT_EQ(stretch.end, stamp_of(299));
  EXPECT_EQ(stretch.scans, 200U);
  EXPECT_NEAR(stretch.way, 200.0, 1.5);
  EXPECT_NEAR(stretch.expected_error, 10.0, 0.5);
  EXPECT_LT((stretch.place - place_of(100)).norm(), 1.0);
  ASSERT_EQ(warnings(doubt).size(), 1U);
  EXPECT_EQ(warnings(doubt).front(),
            "Do not trust this map between 10.0 s and 29.9 s (200 m of 399 m of way): nothing "
            "observed the motion along the way; expected error 10 m");
}

TEST(DriveDoubt, TrustsAWayThatLoopsHold) {
  std::vector<Loop> loops;
  for (KeyFrameIndex i = 40; i < 160; i += 4) loops.push_back(loop_between(10, i));
  const DriveDoubt doubt = doubt_of(tunnel(), loops);
  ASSERT_EQ(doubt.stretches.size(), 1U);
  EXPECT_LT(doubt.stretches.front().expected_error, 1.0);
  EXPECT_TRUE(doubt.is_trusted());
  EXPECT_EQ(remark(doubt), "Noticed: 200 scans degenerate in 1 place (doubt.csv)");
}

TEST(DriveDoubt, TrustsAWayThatAMeasuredSpeedTold) {
  StraightDrive drive = tunnel();
  drive.unobserved = [](KeyFrameIndex scan) { return scan < 100 ? 0.0 : 0.3; };
  EXPECT_TRUE(doubt_of(drive).is_trusted());
}

StraightDrive probably_wrong() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(scan >= 100 && scan < 140 ? "degraded" : "tracking");
  };
  drive.degraded_sigma = 0.3;
  return drive;
}

TEST(DriveDoubt, DoesNotTrustStepsThatAreProbablyWrong) {
  const DriveDoubt doubt = doubt_of(probably_wrong());
  ASSERT_EQ(doubt.stretches.size(), 1U);
  const DoubtfulStretch& stretch = doubt.stretches.front();
  EXPECT_EQ(stretch.doubt, Doubt::kDegraded);
  EXPECT_FALSE(stretch.is_trusted);
  EXPECT_NEAR(stretch.lowest_probability, 0.2, 1e-9);
  // Twenty steps of 0.3 m in each of three axes.
  EXPECT_GT(stretch.expected_error, 2.2);
  EXPECT_LT(stretch.expected_error, 4.0);
  ASSERT_EQ(warnings(doubt).size(), 1U);
  EXPECT_NE(warnings(doubt).front().find("40 of its steps are degraded"), std::string::npos)
      << warnings(doubt).front();
}

TEST(DriveDoubt, TrustsProbablyWrongStepsThatLoopsHold) {
  std::vector<Loop> loops;
  for (KeyFrameIndex i = 48; i < 76; i += 2) loops.push_back(loop_between(10, i));
  const DriveDoubt doubt = doubt_of(probably_wrong(), loops);
  ASSERT_EQ(doubt.stretches.size(), 1U);
  EXPECT_LT(doubt.stretches.front().expected_error, 0.5);
  EXPECT_TRUE(doubt.is_trusted());
}

StraightDrive probably_turned_wrongly() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(scan >= 100 && scan < 140 ? "doubtful" : "tracking");
  };
  return drive;
}

// Twenty steps of 2 m, each with 0.01 rad: the k-th last of them is 2 m k off at the end, aside and
// up; in all 0.02 m sqrt(2 (0^2 + 1^2 + ... + 19^2)).
TEST(DriveDoubt, KnowsThatAWrongTurnLeadsAstray) {
  const DriveDoubt doubt = doubt_of(probably_turned_wrongly());
  ASSERT_EQ(doubt.stretches.size(), 1U);
  const DoubtfulStretch& stretch = doubt.stretches.front();
  EXPECT_EQ(stretch.doubt, Doubt::kDoubtful);
  EXPECT_NEAR(stretch.expected_error, 1.4, 0.2);
  EXPECT_FALSE(stretch.is_trusted);
  std::vector<Loop> loops;
  for (KeyFrameIndex i = 48; i < 76; i += 2) loops.push_back(loop_between(10, i));
  EXPECT_TRUE(doubt_of(probably_turned_wrongly(), loops).is_trusted());
}

StraightDrive lost_for_a_moment() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(scan >= 100 && scan < 103 ? "lost" : "tracking");
  };
  return drive;
}

TEST(DriveDoubt, OnlyMentionsWhatWasFoundAgain) {
  const DriveDoubt doubt = doubt_of(lost_for_a_moment());
  EXPECT_TRUE(doubt.is_trusted());
  EXPECT_EQ(remark(doubt), "Noticed: 3 scans lost in 1 place (doubt.csv)");
}

TEST(DriveDoubt, DoesNotTrustPartsThatNothingJoins) {
  StraightDrive drive = lost_for_a_moment();
  drive.segment_from = 103;
  const DriveDoubt doubt = doubt_of(drive);
  ASSERT_EQ(doubt.stretches.size(), 1U);
  EXPECT_FALSE(doubt.stretches.front().is_trusted);
  EXPECT_TRUE(std::isinf(doubt.stretches.front().expected_error));
  EXPECT_EQ(warnings(doubt).front(),
            "Do not trust how the parts of this map lie to each other: at 10.0 s (99 m of 399 m "
            "of way) the odometry was lost, and no loop or GNSS joins what came before and after");
  EXPECT_TRUE(doubt_of(drive, {loop_between(40, 80), loop_between(44, 84)}).is_trusted());
}

// A front end that was started again begins a segment without being lost.
TEST(DriveDoubt, DoesNotTrustABreakThatNothingJoins) {
  StraightDrive drive;
  drive.segment_from = 200;
  const DriveDoubt doubt = doubt_of(drive);
  ASSERT_EQ(doubt.stretches.size(), 1U);
  EXPECT_EQ(doubt.stretches.front().begin, stamp_of(198));
  EXPECT_FALSE(doubt.is_trusted());
}

TEST(DriveDoubt, GathersScansOfAKind) {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    const bool flickers = scan >= 100 && scan < 130 && scan % 3 == 0;
    return std::string(scan == 110   ? "repeated"
                       : flickers    ? "degraded"
                       : scan == 200 ? "degraded"
                                     : "tracking");
  };
  const DriveDoubt doubt = doubt_of(drive);
  ASSERT_EQ(doubt.stretches.size(), 3U);
  EXPECT_EQ(doubt.stretches[0].scans, 10U);
  EXPECT_EQ(doubt.stretches[1].doubt, Doubt::kRepeated);
  EXPECT_EQ(doubt.stretches[2].begin, stamp_of(200));
  EXPECT_EQ(remark(doubt),
            "Noticed: 1 scan repeated in 1 place, 11 scans degraded in 2 places (doubt.csv)");
}

TEST(DriveDoubt, SaysWhereItsFileIsBroken) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "doubt.csv") << "kind\nlost,1,what\n";
  try {
    read_doubt(folder.path() / "doubt.csv");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("doubt.csv:2: 'lost,1,what'"), std::string::npos);
  }
}

TEST(DriveDoubt, RefusesNumbersThatAreNone) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "doubt.csv";
  const std::string whole = "lost,1.0,2.0,1000000000,2000000000,11,3.0,4.0,90.0,1,2,3,inf,0.5,no";
  const auto read = [&path](const std::string& line) {
    std::ofstream(path) << "kind\n" << line << "\n";
    return read_doubt(path);
  };
  EXPECT_TRUE(std::isinf(read(whole).stretches.at(0).expected_error));
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{",4.0,", ",nan,"},
                                                        {",90.0,", ",inf,"},
                                                        {",1,2,3,", ",1,1e300,3,"},
                                                        {",11,", ",-1,"},
                                                        {",11,", ",11x,"},
                                                        {"2000000000", "9223372036854775807"},
                                                        {",1.0,", ",1e300,"},
                                                        {"inf", "-1"},
                                                        {",0.5,", ",half,"},
                                                        {",no", ""}}) {
    std::string line = whole;
    line.replace(line.find(from), from.size(), to);
    EXPECT_THROW(read(line), InputError) << line;
  }
}

}  // namespace
}  // namespace lidar_mapping::pipeline
