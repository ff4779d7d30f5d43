// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "examined_example.hpp"
#include "holds.hpp"
#include "report_examination.hpp"

namespace lidar_mapping::report {
namespace {

using json::Json;
using localization::LocalizationState;
using test::holds;

Json verdict_on(const ExaminedDrive& drive) {
  return examination_verdict(examination_figures(drive, straight_map()));
}

std::string value_of(const ExaminedDrive& drive) {
  return verdict_on(drive)["value"].get<std::string>();
}

TEST(ExaminationVerdict, IsGoodForADriveThatWasFollowed) {
  const Json line = verdict_on(straight_drive());
  EXPECT_EQ(line["name"], "Examination by tuesday_in_monday");
  EXPECT_EQ(line["good"], true);
  EXPECT_EQ(line["value"], "100.0 % of 55.0 m in the map followed");
  EXPECT_EQ(line["note"],
            "found after 0.5 s and 5.0 m; agreement 0.80, a tenth of the scans below 0.80; motion "
            "over 10 m up to 0.00 m from odometry");
  EXPECT_EQ(line["limit"],
            "found, 95 % of the path in the map followed, never lost there, no jump, agreement of "
            "each section of 20 m above 0.25");
}

// One scan in 2000 is enough, wherever the rest was followed.
TEST(ExaminationVerdict, IsNeverGoodWhereTheDriveWasLostInTheMap) {
  ExaminedDrive drive = straight_drive();
  for (int i = 0; i < 2000; ++i) {
    drive.scans.push_back(drive.scans.back());
    drive.scans.back().stamp += kNanosecondsPerSecond / 10;
  }
  set_state(drive, 30, 31, LocalizationState::kLost);
  EXPECT_EQ(verdict_on(drive)["good"], false);
  EXPECT_EQ(value_of(drive),
            "98.2 % of 55.0 m in the map followed; lost 1 time in it (first key frame 14 at 29.0, "
            "1.0)");
  set_state(drive, 50, 51, LocalizationState::kLost);
  EXPECT_TRUE(holds(value_of(drive), "lost 2 times in it"));
}

TEST(ExaminationVerdict, AllowsALossBeyondTheEndOfTheMap) {
  ExaminedDrive drive = straight_drive(100);
  set_state(drive, 85, 100, LocalizationState::kLost);
  EXPECT_EQ(verdict_on(drive)["good"], true) << value_of(drive);
}

TEST(ExaminationVerdict, IsBadForADriveThatWasNeverFound) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 0, 60, LocalizationState::kSearching);
  EXPECT_EQ(verdict_on(drive)["good"], false);
  EXPECT_EQ(value_of(drive), "never found in the map");
  EXPECT_EQ(verdict_on(drive)["note"], "searched over 59 m");
}

// Three metres of 55 beside the map are more than a twentieth.
TEST(ExaminationVerdict, AsksForMostOfThePathInTheMap) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 10, 12, LocalizationState::kBesideMap);
  EXPECT_EQ(verdict_on(drive)["good"], true) << value_of(drive);
  set_state(drive, 10, 13, LocalizationState::kBesideMap);
  EXPECT_EQ(verdict_on(drive)["good"], false);
  EXPECT_EQ(value_of(drive), "94.5 % of 55.0 m in the map followed");
}

TEST(ExaminationVerdict, NamesJumpsAndWeakSections) {
  ExaminedDrive drive = straight_drive();
  for (std::size_t i = 40; i < 60; ++i) {
    drive.scans[i].T_map_base.translation.y() += 0.8;
    drive.scans[i].agreement = 0.2;
  }
  EXPECT_EQ(verdict_on(drive)["good"], false);
  const std::string value = value_of(drive);
  EXPECT_TRUE(holds(value, "; 1 jump (largest 0.80 m, key frame 2"));
  EXPECT_TRUE(holds(value, "; 1 weak section (worst key frames 20 to 29 at 48.0, 0.0)"));
}

TEST(ExaminationVerdict, SaysNothingAfterAFewMetres) {
  const ExaminedDrive drive = straight_drive(20);
  EXPECT_TRUE(verdict_on(drive)["good"].is_null());
  EXPECT_EQ(value_of(drive),
            "100.0 % of 15.0 m in the map followed; too short to judge the map by");
}

}  // namespace
}  // namespace lidar_mapping::report
