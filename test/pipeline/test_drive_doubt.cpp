// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using session::Session;
using test::TemporaryFolder;

constexpr double kSpeed = 10.0;        // m/s
constexpr double kPeriod = 0.1;        // s
constexpr KeyFrameIndex kScans = 400;  // every second one is a key frame

Stamp stamp_of(KeyFrameIndex scan) { return from_seconds(1000.0 + kPeriod * scan); }

Eigen::Vector3d position_of(KeyFrameIndex scan) { return {kSpeed * kPeriod * scan, 0.0, 0.0}; }

/// A straight drive with given states of the scans and given unobserved travel.
struct StraightDrive {
  std::string (*state)(KeyFrameIndex) = [](KeyFrameIndex) { return std::string("tracking"); };
  double (*unobserved_stddev)(KeyFrameIndex) = [](KeyFrameIndex) { return 0.0; };
  double degraded_sigma = 0.003;  ///< Standard deviation of a step to a degraded scan, m.
  KeyFrameIndex second_segment_begin =
      kScans;                     ///< First scan of a second segment of the trajectory.
  Stamp delay = 0;                ///< Added to all stamps.
  KeyFrameIndex first_index = 0;  ///< Index of the first key frame.
  std::uint32_t segment = 0;      ///< Segment in which the drive begins.
  std::uint32_t number = 0;       ///< Of the drive in the session.
  double aside = 0.0;             ///< Added to y of the odometry, m.

  void write(RecordedBackEnd& back_end) const {
    for (KeyFrameIndex scan = 0; scan < kScans; ++scan) {
      session::ScanRecord record;
      record.stamp = stamp_of(scan) + delay;
      record.state = state(scan);
      record.unobserved_stddev = unobserved_stddev(scan);
      record.probability = record.state == "degraded" ? 0.2 : 0.99;
      back_end.session().add_scan(record);
      const Pose T_odom_base{Eigen::Quaterniond::Identity(),
                             position_of(scan) + aside * Eigen::Vector3d::UnitY()};
      back_end.session().add_odometry({record.stamp, T_odom_base, number});
      if (scan % 2 != 0 || record.state == "lost") continue;
      KeyFrame key_frame;
      key_frame.index = first_index + scan / 2;
      key_frame.segment = segment + (scan < second_segment_begin ? 0U : 1U);
      key_frame.stamp = record.stamp;
      key_frame.T_odom_base = T_odom_base;
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
      back_end.add_key_frame(key_frame);
    }
  }
};

Loop loop_between(KeyFrameIndex from, KeyFrameIndex to) {
  Loop loop;
  loop.from = from;
  loop.to = to;
  loop.T_from_to.translation = position_of(2 * to) - position_of(2 * from);
  loop.covariance = diagonal_covariance(0.02, 0.002);
  loop.overlap = 0.9;
  return loop;
}

/// Contents of doubt.csv of the drives with these loops.
DriveDoubt doubt_of(const std::vector<StraightDrive>& drives, const std::vector<Loop>& loops) {
  const TemporaryFolder folder;
  RecordedBackEnd back_end(Session::create_in(folder.path()), {});
  for (const StraightDrive& drive : drives) drive.write(back_end);
  for (const Loop& loop : loops) back_end.add_loop(loop);
  back_end.apply(*back_end::solve(*back_end.problem(true)), 0.0);
  back_end.write_files();
  return read_doubt(folder.path() / "doubt.csv");
}

DriveDoubt doubt_of(const StraightDrive& drive, const std::vector<Loop>& loops = {}) {
  return doubt_of(std::vector<StraightDrive>{drive}, loops);
}

bool in_tunnel(KeyFrameIndex scan) { return scan >= 100 && scan < 300; }

/// A section of 200 m at whose end the unobserved travel has a standard deviation of 10 m.
StraightDrive degenerate_drive() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(in_tunnel(scan) ? "degenerate" : "tracking");
  };
  drive.unobserved_stddev = [](KeyFrameIndex scan) {
    return scan < 100 ? 0.0 : 10.0 * std::min(1.0, (scan - 99.0) / 200.0);
  };
  return drive;
}

TEST(DriveDoubt, ReportsNothingForCleanDrive) {
  const DriveDoubt doubt = doubt_of({});
  EXPECT_TRUE(doubt.is_trusted());
  EXPECT_TRUE(doubt.sections.empty());
  EXPECT_TRUE(warnings(doubt).empty());
  EXPECT_EQ(remark(doubt), "");
}

TEST(DriveDoubt, DoesNotTrustUnobservedTravel) {
  const DriveDoubt doubt = doubt_of(degenerate_drive());
  ASSERT_EQ(doubt.sections.size(), 1U);
  const DoubtfulSection& section = doubt.sections.front();
  EXPECT_EQ(section.doubt, Doubt::kDegenerate);
  EXPECT_EQ(section.begin, stamp_of(100));
  EXPECT_EQ(section.end, stamp_of(299));
  EXPECT_EQ(section.scans, 200U);
  EXPECT_NEAR(section.path_length, 200.0, 1.5);
  EXPECT_NEAR(section.expected_error, 10.0, 0.5);
  EXPECT_TRUE(test::near(section.position, position_of(100), 1.0));
  ASSERT_EQ(warnings(doubt).size(), 1U);
  EXPECT_EQ(warnings(doubt).front(),
            "Do not trust this map between 10.0 s and 29.9 s (200 m of 399 m of path): nothing "
            "observed the motion along the path; expected error 10 m");
}

TEST(DriveDoubt, TrustsUnobservedTravelConstrainedByLoops) {
  std::vector<Loop> loops;
  for (KeyFrameIndex i = 40; i < 160; i += 4) loops.push_back(loop_between(10, i));
  const DriveDoubt doubt = doubt_of(degenerate_drive(), loops);
  ASSERT_EQ(doubt.sections.size(), 1U);
  EXPECT_LT(doubt.sections.front().expected_error, 1.0);
  EXPECT_TRUE(doubt.is_trusted());
  EXPECT_EQ(remark(doubt), "Noticed: 200 scans degenerate in 1 place (doubt.csv)");
}

TEST(DriveDoubt, TrustsUnobservedTravelWithMeasuredSpeed) {
  StraightDrive drive = degenerate_drive();
  drive.unobserved_stddev = [](KeyFrameIndex scan) { return scan < 100 ? 0.0 : 0.3; };
  EXPECT_TRUE(doubt_of(drive).is_trusted());
}

// A front end that was started again in a second tunnel counts its unobserved travel from 0, while
// that of the first tunnel was 10 m.
TEST(DriveDoubt, DoesNotTrustUnobservedTravelAfterARestart) {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    const bool unobserved = (scan >= 20 && scan < 60) || (scan >= 200 && scan < 300);
    return std::string(unobserved ? "degenerate" : "tracking");
  };
  drive.unobserved_stddev = [](KeyFrameIndex scan) {
    if (scan < 20) return 0.0;
    if (scan < 200) return 10.0 * std::min(1.0, (scan - 19.0) / 40.0);
    return 9.0 * std::min(1.0, (scan - 199.0) / 100.0);
  };
  drive.second_segment_begin = 200;
  const DriveDoubt doubt = doubt_of(drive);
  std::size_t found = 0;
  for (const DoubtfulSection& section : doubt.sections) {
    if (section.doubt != Doubt::kDegenerate || section.begin != stamp_of(200)) continue;
    ++found;
    EXPECT_GT(section.expected_error, 0.3);
    EXPECT_FALSE(section.is_trusted);
  }
  EXPECT_EQ(found, 1U);
}

StraightDrive degraded_drive() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(scan >= 100 && scan < 140 ? "degraded" : "tracking");
  };
  drive.degraded_sigma = 0.3;
  return drive;
}

TEST(DriveDoubt, DoesNotTrustDegradedSteps) {
  const DriveDoubt doubt = doubt_of(degraded_drive());
  ASSERT_EQ(doubt.sections.size(), 1U);
  const DoubtfulSection& section = doubt.sections.front();
  EXPECT_EQ(section.doubt, Doubt::kDegraded);
  EXPECT_FALSE(section.is_trusted);
  ASSERT_TRUE(section.lowest_probability.has_value());
  EXPECT_NEAR(*section.lowest_probability, 0.2, 1e-9);
  // Twenty steps of 0.3 m in each of three axes.
  EXPECT_GT(section.expected_error, 2.2);
  EXPECT_LT(section.expected_error, 4.0);
  ASSERT_EQ(warnings(doubt).size(), 1U);
  EXPECT_NE(warnings(doubt).front().find("40 of its steps are degraded"), std::string::npos)
      << warnings(doubt).front();
}

// A session of two drives whose first one was recorded later.
TEST(DriveDoubt, KnowsDrivesThatWereMergedInReverse) {
  StraightDrive later = degraded_drive();
  later.delay = from_seconds(1000.0);
  StraightDrive earlier;
  earlier.first_index = kScans / 2;
  earlier.segment = 1;
  const DriveDoubt doubt = doubt_of(std::vector<StraightDrive>{later, earlier}, {});
  ASSERT_EQ(doubt.sections.size(), 2U);
  const DoubtfulSection& between = doubt.sections[0];
  EXPECT_EQ(between.doubt, Doubt::kLost);
  EXPECT_EQ(between.begin, stamp_of(kScans - 2));
  EXPECT_EQ(between.end, stamp_of(0) + later.delay);
  const DoubtfulSection& degraded = doubt.sections[1];
  EXPECT_EQ(degraded.doubt, Doubt::kDegraded);
  EXPECT_EQ(degraded.begin, stamp_of(100) + later.delay);
  EXPECT_FALSE(degraded.is_trusted);
  EXPECT_GT(degraded.expected_error, 2.2);
  EXPECT_LT(degraded.expected_error, 4.0);
}

// Two vehicles at once, whose odometries are 500 m apart.
TEST(DriveDoubt, KnowsDrivesThatOverlapInTime) {
  const DriveDoubt alone = doubt_of(degraded_drive());
  StraightDrive other;
  other.delay = from_seconds(0.05);
  other.aside = 500.0;
  for (const bool degraded_is_first : {true, false}) {
    std::vector<StraightDrive> drives = {degraded_drive(), other};
    if (!degraded_is_first) std::swap(drives[0], drives[1]);
    drives[1].first_index = kScans / 2;
    drives[1].segment = drives[1].number = 1;
    const DriveDoubt doubt = doubt_of(drives, {});
    EXPECT_NEAR(doubt.path_length, 2.0 * alone.path_length, 1e-3);
    ASSERT_EQ(doubt.sections.size(), 2U);
    const DoubtfulSection& apart = doubt.sections[0];
    EXPECT_EQ(apart.doubt, Doubt::kLost);
    EXPECT_EQ(apart.begin, stamp_of(0) + other.delay);
    EXPECT_LE(apart.begin, apart.end);
    EXPECT_FALSE(apart.is_trusted);
    const DoubtfulSection& degraded = doubt.sections[1];
    EXPECT_EQ(degraded.doubt, Doubt::kDegraded);
    EXPECT_EQ(degraded.begin, stamp_of(100));
    EXPECT_EQ(degraded.end, stamp_of(139));
    EXPECT_NEAR(degraded.path_length, alone.sections.at(0).path_length, 1e-3);
    EXPECT_NEAR(degraded.expected_error, alone.sections.at(0).expected_error, 1e-3);
    EXPECT_FALSE(degraded.is_trusted);
    EXPECT_TRUE(test::near(degraded.position, alone.sections.at(0).position, 0.01));
    ASSERT_TRUE(degraded.key_frames);
    const KeyFrameIndex first_of_drive = degraded_is_first ? 0 : kScans / 2;
    EXPECT_EQ(degraded.key_frames->first, first_of_drive + 49);
    EXPECT_EQ(degraded.key_frames->last, first_of_drive + 70);
  }
}

// The way back in the odometry from the end of a drive to the beginning of the next is none.
TEST(DriveDoubt, DoesNotCountThePathBetweenTwoDrives) {
  StraightDrive later;
  later.state = [](KeyFrameIndex scan) { return std::string(scan < 10 ? "degraded" : "tracking"); };
  later.delay = from_seconds(1000.0);
  later.first_index = kScans / 2;
  later.segment = 1;
  const DriveDoubt doubt = doubt_of(std::vector<StraightDrive>{{}, later}, {});
  EXPECT_NEAR(doubt.path_length, 2.0 * position_of(kScans - 1).x(), 1e-3);
  ASSERT_FALSE(doubt.sections.empty());
  const DoubtfulSection& degraded = doubt.sections.back();
  EXPECT_EQ(degraded.doubt, Doubt::kDegraded);
  EXPECT_NEAR(degraded.path_begin, position_of(kScans - 1).x(), 1e-3);
  EXPECT_NEAR(degraded.path_length, position_of(9).x(), 1e-3);
}

TEST(DriveDoubt, TrustsDegradedStepsConstrainedByLoops) {
  std::vector<Loop> loops;
  for (KeyFrameIndex i = 48; i < 76; i += 2) loops.push_back(loop_between(10, i));
  const DriveDoubt doubt = doubt_of(degraded_drive(), loops);
  ASSERT_EQ(doubt.sections.size(), 1U);
  EXPECT_LT(doubt.sections.front().expected_error, 0.5);
  EXPECT_TRUE(doubt.is_trusted());
}

StraightDrive doubtful_drive() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(scan >= 100 && scan < 140 ? "doubtful" : "tracking");
  };
  return drive;
}

// Twenty steps of 2 m, each with 0.01 rad: the k-th last of them causes 2 m * k * 0.01 sideways and
// upwards at the end; in all 0.02 m sqrt(2 (0^2 + 1^2 + ... + 19^2)).
TEST(DriveDoubt, PropagatesErrorsOfRotation) {
  const DriveDoubt doubt = doubt_of(doubtful_drive());
  ASSERT_EQ(doubt.sections.size(), 1U);
  const DoubtfulSection& section = doubt.sections.front();
  EXPECT_EQ(section.doubt, Doubt::kDoubtful);
  EXPECT_NEAR(section.expected_error, 1.4, 0.2);
  EXPECT_FALSE(section.is_trusted);
  std::vector<Loop> loops;
  for (KeyFrameIndex i = 48; i < 76; i += 2) loops.push_back(loop_between(10, i));
  EXPECT_TRUE(doubt_of(doubtful_drive(), loops).is_trusted());
}

StraightDrive briefly_lost_drive() {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    return std::string(scan >= 100 && scan < 103 ? "lost" : "tracking");
  };
  return drive;
}

TEST(DriveDoubt, LostScansWithinASegmentAreRemarks) {
  const DriveDoubt doubt = doubt_of(briefly_lost_drive());
  EXPECT_TRUE(doubt.is_trusted());
  EXPECT_EQ(remark(doubt), "Noticed: 3 scans lost in 1 place (doubt.csv)");
}

TEST(DriveDoubt, DoesNotTrustUnconnectedParts) {
  StraightDrive drive = briefly_lost_drive();
  drive.second_segment_begin = 103;
  const DriveDoubt doubt = doubt_of(drive);
  ASSERT_EQ(doubt.sections.size(), 1U);
  EXPECT_FALSE(doubt.sections.front().is_trusted);
  EXPECT_TRUE(std::isinf(doubt.sections.front().expected_error));
  EXPECT_EQ(warnings(doubt).front(),
            "Do not trust the relative pose of the parts of this map: at 10.0 s (99 m of 399 m of "
            "path) the odometry was lost, and no loop or GNSS connects the parts before and after");
  EXPECT_TRUE(doubt_of(drive, {loop_between(40, 80), loop_between(44, 84)}).is_trusted());
}

// A restarted front end begins a new segment without being lost.
TEST(DriveDoubt, DoesNotTrustUnconnectedSegments) {
  StraightDrive drive;
  drive.second_segment_begin = 200;
  const DriveDoubt doubt = doubt_of(drive);
  ASSERT_EQ(doubt.sections.size(), 1U);
  EXPECT_EQ(doubt.sections.front().begin, stamp_of(198));
  EXPECT_FALSE(doubt.is_trusted());
}

TEST(DriveDoubt, GroupsScansWithTheSameReason) {
  StraightDrive drive;
  drive.state = [](KeyFrameIndex scan) {
    const bool flickers = scan >= 100 && scan < 130 && scan % 3 == 0;
    return std::string(scan == 110   ? "repeated"
                       : flickers    ? "degraded"
                       : scan == 200 ? "degraded"
                                     : "tracking");
  };
  const DriveDoubt doubt = doubt_of(drive);
  ASSERT_EQ(doubt.sections.size(), 3U);
  EXPECT_EQ(doubt.sections[0].scans, 10U);
  EXPECT_EQ(doubt.sections[1].doubt, Doubt::kRepeated);
  EXPECT_EQ(doubt.sections[2].begin, stamp_of(200));
  EXPECT_EQ(remark(doubt),
            "Noticed: 1 scan repeated in 1 place, 11 scans degraded in 2 places (doubt.csv)");
}

TEST(DriveDoubt, ReportsDamagedLineOfFile) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "doubt.csv") << "kind\nlost,1,what\n";
  const std::string text =
      test::error_text<InputError>([&] { read_doubt(folder.path() / "doubt.csv"); });
  EXPECT_NE(text.find("doubt.csv:2: 'lost,1,what'"), std::string::npos) << text;
}

TEST(DriveDoubt, RejectsInvalidNumbers) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "doubt.csv";
  const std::string whole =
      "lost,1.0,2.0,1000000000,2000000000,11,3.0,4.0,90.0,1,2,3,inf,0.5,7,9,no";
  const auto read = [&path](const std::string& line) {
    std::ofstream(path) << "kind\n" << line << "\n";
    return read_doubt(path);
  };
  EXPECT_TRUE(std::isinf(read(whole).sections.at(0).expected_error));
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
                                                        {",7,9,", ",-7,9,"},
                                                        {",7,9,", ",9,7,"},
                                                        {",7,9,", ",7,,"},
                                                        {",7,9,", ",7,4294967296,"},
                                                        {",no", ""}}) {
    std::string line = whole;
    line.replace(line.find(from), from.size(), to);
    EXPECT_THROW(read(line), InputError) << line;
  }
}

TEST(DriveDoubt, ReadsFilesWithoutKeyFrames) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "doubt.csv")
      << "kind\nlost,1.0,2.0,1000000000,2000000000,11,3.0,4.0,90.0,1,2,3,inf,0.5,no\n"
      << "lost,1.0,2.0,1000000000,2000000000,11,3.0,4.0,90.0,1,2,3,inf,0.5,,,yes\n";
  const DriveDoubt doubt = read_doubt(folder.path() / "doubt.csv");
  ASSERT_EQ(doubt.sections.size(), 2U);
  EXPECT_FALSE(doubt.sections[0].is_trusted);
  EXPECT_FALSE(doubt.sections[0].key_frames);
  EXPECT_TRUE(doubt.sections[1].is_trusted);
  EXPECT_FALSE(doubt.sections[1].key_frames);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
