// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "error_text.hpp"
#include "examined_example.hpp"
#include "file_content.hpp"
#include "holds.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::report {
namespace {

namespace fs = std::filesystem;
using localization::LocalizationState;
using test::holds;

class ExaminedDriveFiles : public testing::Test {
 protected:
  ExaminedDriveFiles() { write_drive(drive_, straight_drive(), map_); }

  ExaminedDrive read() const { return read_examined_drive(drive_, map_, "monday"); }
  std::string refusal() const {
    return test::error_text<InputError>([this] { read(); });
  }
  /// Why the file is refused with other words in the place of some.
  std::string refusal_with(const std::string& file, const std::string& words,
                           const std::string& others) const {
    const std::string whole = test::content_of(drive_ / file);
    std::string spoilt = whole;
    const std::size_t begin = whole.find(words);
    EXPECT_NE(begin, std::string::npos) << words;
    if (begin != std::string::npos) spoilt.replace(begin, words.size(), others);
    std::ofstream(drive_ / file) << spoilt;
    const std::string answer = refusal();
    std::ofstream(drive_ / file) << whole;
    return answer;
  }
  std::string refusal_with(const std::string& words, const std::string& others) const {
    return refusal_with("localization.csv", words, others);
  }

  const test::TemporaryFolder folder_;
  const fs::path drive_ = folder_.path() / "tuesday_in_monday";
  KeyFramePoses map_ = straight_map();
};

TEST_F(ExaminedDriveFiles, HoldWhatLocalizeBagFound) {
  ExaminedDrive written = straight_drive();
  written.scans[7].stamp += 123;
  written.scans[7].reason = "the map shows it, all of it";
  written.scans[8].segment = 0;
  for (std::size_t i = 9; i < written.scans.size(); ++i) written.scans[i].segment = 2;
  set_state(written, 9, 12, LocalizationState::kLost);
  write_drive(drive_, written, map_);
  const ExaminedDrive drive = read_examined_drive(drive_ / "", map_, "monday");
  EXPECT_EQ(drive.name, "tuesday_in_monday");
  EXPECT_EQ(drive.recordings, std::vector<std::string>{"tuesday.bag"});
  ASSERT_EQ(drive.scans.size(), 60U);
  const ExaminedScan& scan = drive.scans[7];
  EXPECT_EQ(scan.stamp, written.scans[7].stamp);
  EXPECT_EQ(scan.state, LocalizationState::kFollowing);
  EXPECT_TRUE(test::near(scan.T_map_base, written.scans[7].T_map_base, 1e-6));
  EXPECT_TRUE(test::near(scan.T_odom_base, written.scans[7].T_odom_base, 1e-6));
  EXPECT_EQ(scan.path, 7.0);
  EXPECT_EQ(scan.agreement, 0.8);
  EXPECT_EQ(scan.coverage, 0.9);
  EXPECT_EQ(scan.reason, written.scans[7].reason);
  EXPECT_EQ(drive.scans[0].state, LocalizationState::kSearching);
  EXPECT_EQ(drive.scans[8].segment, 0U);
  EXPECT_EQ(drive.scans[9].segment, 2U);
  EXPECT_EQ(drive.scans[9].state, LocalizationState::kLost);
}

TEST_F(ExaminedDriveFiles, AreRefusedIfTheTableIsDamaged) {
  struct Fault {
    const char* words;
    const char* others;
    const char* answer;
  };
  const Fault faults[] = {
      {"coverage,hypotheses", "covers,hypotheses", "has no column 'coverage'"},
      {",following,", ",folowing,", "there is no such state"},
      {",0.8000,0.9000,", ",1.8000,0.9000,", "'1.8000' is not between 0 and 1"},
      {",0.8000,0.9000,", ",0.8000,-0.1000,", "'-0.1000' is not between 0 and 1"},
      {",0.8000,0.9000,", ",nan,0.9000,", "'nan' is no finite number"},
      {",0.8000,0.9000,", ",0.8000,", "21 cells instead of 22"},
      {",1.0000,0,\"", ",-1.0000,0,\"", "a path is not negative"},
      {",2.0000,0,\"", ",0.5000,0,\"", "the path is shorter than before"},
      {",1.0000,0,\"", ",1.0000,-1,\"", "'-1' is no whole number"},
      {",1.0000,0,\"", ",1.0000,1,\"", "the segment is one before"},
      {",5.0000,1.0000,0.0000,", ",,1.0000,0.0000,", "'' is no finite number"},
      {",1.000000000,0.01,", ",9.000000000,0.01,", "quaternion is not of unit length"},
      {"\n1600086400.100000000,", "\n1600086400.000000000,",
       "the stamp is not after the one before"},
      {"\n1600086400.100000000,", "\nyesterday,", "'yesterday' is no finite number"}};
  ASSERT_EQ(refusal(), "");
  for (const Fault& fault : faults) {
    const std::string answer = refusal_with(fault.words, fault.others);
    for (const char* part :
         {fault.answer, "localization.csv", "; localize_bag writes the files again"}) {
      EXPECT_TRUE(holds(answer, part)) << fault.others;
    }
  }
  const std::string answer = refusal_with(",following,", ",folowing,");
  EXPECT_TRUE(holds(answer, "localization.csv:7: "));
}

TEST_F(ExaminedDriveFiles, AreRefusedWhereTheyDoNotBelongTogether) {
  ExaminedDrive drive = straight_drive();
  std::ofstream(drive_ / "localization.csv") << table_of({});
  EXPECT_TRUE(holds(refusal(), "has no scan"));
  drive.scans.pop_back();
  std::ofstream(drive_ / "localization.csv") << table_of(drive.scans);
  EXPECT_TRUE(holds(refusal(), "does not hold the scans of localization.csv"));
}

TEST_F(ExaminedDriveFiles, AreMissedWhereTheyAreNot) {
  EXPECT_TRUE(holds(
      test::error_text<FileError>([this] { read_examined_drive(folder_.path(), map_, "monday"); }),
      "there is no localization.json in"));
  fs::remove(drive_ / "trajectory/laser_odom_scans.tum");
  EXPECT_THROW(read(), FileError);
}

TEST_F(ExaminedDriveFiles, AreRefusedWithADamagedRecord) {
  for (const auto& [words, others] :
       {std::pair("\"key_frames\": 30", "\"key_frames\": -30"),
        std::pair("\"key_frames\": 30", "\"key_frames\": true"),
        std::pair("\"digest\"", "\"digits\""), std::pair("\"monday\"", "5"),
        std::pair("\"tuesday.bag\"", "7"), std::pair("{", "")}) {
    const std::string answer = refusal_with("localization.json", words, others);
    EXPECT_TRUE(holds(answer, "localization.json is damaged: ")) << others;
  }
}

TEST_F(ExaminedDriveFiles, ExamineTheMapInWhichTheDriveWasLocalised) {
  map_.poses.pop_back();
  EXPECT_TRUE(holds(refusal(),
                    "it was localised in the map monday (30 key frames), which is another "
                    "one than monday (29 key frames); localise it in this map"));
  map_ = straight_map();
  map_.poses[3].stamp += 1;
  EXPECT_TRUE(holds(refusal(), "which is another one than"));
  map_ = straight_map();
  map_.poses[3].T_map_base.translation.z() += 0.01;
  EXPECT_TRUE(holds(refusal(), "the poses of the map monday have changed since"));
  map_ = straight_map();
  EXPECT_NO_THROW(read_examined_drive(drive_, map_, "copy of monday"));
}

// However wrong a map is, the drive that made it agrees with it.
TEST_F(ExaminedDriveFiles, DoNotExamineTheMapOfTheDriveItself) {
  ExaminedDrive drive = straight_drive();
  for (ExaminedScan& scan : drive.scans) scan.stamp -= kTuesday - kMonday;
  write_drive(drive_, drive, map_);
  EXPECT_TRUE(holds(refusal(), "the map was made from it: key frame 0 is one of its scans"));
}

// Two drives may both begin at the time 0 of their sensor.
TEST_F(ExaminedDriveFiles, MayHaveStampsThatAreNoDates) {
  ExaminedDrive drive = straight_drive();
  for (ExaminedScan& scan : drive.scans) scan.stamp -= kTuesday;
  for (KeyFramePose& pose : map_.poses) pose.stamp -= kMonday;
  write_drive(drive_, drive, map_);
  EXPECT_EQ(refusal(), "");
}

}  // namespace
}  // namespace lidar_mapping::report
