// SPDX-License-Identifier: BSD-3-Clause
// Examinations of a straight map by drives of another day, whose figures are counted by hand.
#include <cmath>

#include <gtest/gtest.h>

#include "examined_example.hpp"
#include "examined_motion.hpp"
#include "examined_sections.hpp"
#include "report_examination.hpp"

namespace lidar_mapping::report {
namespace {

using json::Json;
using localization::LocalizationState;

Json figures_of(const ExaminedDrive& drive) { return examination_figures(drive, straight_map()); }

/// Sections of the map with the scans of a drive.
std::vector<ExaminedSection> sections_of(const ExaminedDrive& drive) {
  const KeyFramePoses map = straight_map();
  return examined_sections(drive.scans, locations_of(drive.scans, map), map);
}

/// Moves the poses in the map from a scan on to the left; odometry knows nothing of it.
void move_left(ExaminedDrive& drive, std::size_t begin, double metres) {
  for (std::size_t i = begin; i < drive.scans.size(); ++i) {
    drive.scans[i].T_map_base.translation.y() += metres;
  }
}

TEST(Examination, CountsScansAndMetresOfEachState) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 10, 13, LocalizationState::kBesideMap);
  set_state(drive, 30, 35, LocalizationState::kLost);
  const Json figures = figures_of(drive);
  EXPECT_EQ(figures["scans"], 60);
  EXPECT_NEAR(figures["path_m"], 59.0, 1e-9);
  EXPECT_NEAR(figures["seconds"], 5.9, 1e-9);
  const Json& states = figures["states"];
  EXPECT_EQ(states["searching"]["scans"], 5);
  EXPECT_NEAR(states["searching"]["path_m"], 4.0, 1e-9);  // to the first scan leads no path
  EXPECT_EQ(states["following"]["scans"], 47);
  EXPECT_NEAR(states["following"]["path_m"], 47.0, 1e-9);
  EXPECT_EQ(states["beside_map"]["scans"], 3);
  EXPECT_EQ(states["lost"]["scans"], 5);
  EXPECT_NEAR(states["lost"]["path_m"], 5.0, 1e-9);
  EXPECT_NEAR(figures["found_after"]["seconds"], 0.5, 1e-9);
  EXPECT_NEAR(figures["found_after"]["metres"], 5.0, 1e-9);
  EXPECT_EQ(figures["in_map"]["scans"], 55);
  EXPECT_NEAR(figures["in_map"]["path_m"], 55.0, 1e-9);
  EXPECT_EQ(figures["in_map"]["followed"]["scans"], 47);
  EXPECT_NEAR(figures["in_map"]["followed"]["path_m"], 47.0, 1e-9);
}

TEST(Examination, HasMeanAndLowestTenthOfTheFollowedScans) {
  ExaminedDrive drive = straight_drive();
  for (std::size_t i = 20; i < 26; ++i) drive.scans[i].agreement = 0.3;
  drive.scans[2].agreement = 0.0;  // while it was searched for
  const Json figures = figures_of(drive);
  EXPECT_NEAR(figures["agreement"]["mean"], (49 * 0.8 + 6 * 0.3) / 55, 1e-9);
  EXPECT_NEAR(figures["agreement"]["lowest_tenth"], 0.3, 1e-9);
  EXPECT_NEAR(figures["coverage"]["mean"], 0.9, 1e-9);
}

TEST(Examination, KnowsNothingOfADriveThatWasNeverFound) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 0, 60, LocalizationState::kSearching);
  const Json figures = figures_of(drive);
  EXPECT_TRUE(figures["found_after"].is_null());
  EXPECT_TRUE(figures["agreement"].is_null());
  EXPECT_TRUE(figures["odometry"]["largest"].is_null());
  EXPECT_EQ(figures["in_map"]["scans"], 0);
  ASSERT_EQ(figures["sections"].size(), 3U);
  for (const Json& section : figures["sections"]) EXPECT_TRUE(section["agreement"].is_null());
  const std::string text = examination_text(figures, 10);
  EXPECT_NE(text.find("60 scans over 59 m: never found in the map\n"), std::string::npos) << text;
  EXPECT_NE(text.find("0 of 3 sections of 20 m of the map were passed\n"), std::string::npos);
}

TEST(Examination, GivesTheSectionsOfTheMapTheirScans) {
  ExaminedDrive drive = straight_drive();
  for (std::size_t i = 20; i < 30; ++i) drive.scans[i].agreement = 0.4;
  const auto sections = sections_of(drive);
  ASSERT_EQ(sections.size(), 3U);
  EXPECT_EQ(sections[1].first, 10U);
  EXPECT_EQ(sections[1].last, 19U);
  EXPECT_NEAR(sections[1].begin, 20.0, 1e-9);
  EXPECT_EQ(sections[0].scans, 15U);  // the five before were searched for
  EXPECT_EQ(sections[1].scans, 20U);
  EXPECT_EQ(sections[2].scans, 20U);
  EXPECT_EQ(sections[1].followed, 20U);
  EXPECT_EQ(sections[1].passes, 1U);
  EXPECT_NEAR(sections[1].agreement, 0.6, 1e-9);
  EXPECT_NEAR(sections[2].agreement, 0.8, 1e-9);
  EXPECT_NEAR(sections[2].coverage, 0.9, 1e-9);
}

TEST(Examination, CountsALostScanAsNoAgreementAtItsPlace) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 30, 35, LocalizationState::kLost);
  const auto sections = sections_of(drive);
  EXPECT_EQ(sections[1].scans, 20U);
  EXPECT_EQ(sections[1].followed, 15U);
  EXPECT_NEAR(sections[1].agreement, 0.6, 1e-9);
  EXPECT_NEAR(sections[1].coverage, 0.675, 1e-9);
}

// To the end of the map and back.
TEST(Examination, CountsPasses) {
  ExaminedDrive drive = straight_drive(120);
  for (std::size_t i = 60; i < 120; ++i) {
    drive.scans[i].T_map_base.translation.x() = 119.0 - static_cast<double>(i);
  }
  const auto sections = sections_of(drive);
  EXPECT_EQ(sections[0].passes, 2U);
  EXPECT_EQ(sections[1].passes, 2U);
  EXPECT_EQ(sections[2].passes, 1U);  // it turned there
  EXPECT_EQ(sections[2].scans, 40U);
}

TEST(Examination, SaysWhereThePlaceWasLostInTheMap) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 30, 35, LocalizationState::kLost);
  drive.scans[30].reason = "3 % of the surroundings agree with the map";
  const Json losses = figures_of(drive)["losses"];
  ASSERT_EQ(losses.size(), 1U);
  EXPECT_EQ(losses[0]["in_map"], true);
  EXPECT_EQ(losses[0]["key_frame"], 14);  // at 28 m, nearest to the last scan before, at 29 m
  EXPECT_NEAR(losses[0]["x"], 29.0, 1e-9);
  EXPECT_NEAR(losses[0]["y"], 1.0, 1e-9);
  EXPECT_NEAR(losses[0]["begin_s"], 3.0, 1e-9);
  EXPECT_EQ(losses[0]["scans"], 5);
  EXPECT_NEAR(losses[0]["path_m"], 5.0, 1e-9);
  EXPECT_EQ(losses[0]["reason"], drive.scans[30].reason);
}

TEST(Examination, DoesNotBlameTheMapForALossBeyondItsEnd) {
  ExaminedDrive drive = straight_drive(100);
  set_state(drive, 85, 100, LocalizationState::kLost);
  const Json losses = figures_of(drive)["losses"];
  ASSERT_EQ(losses.size(), 1U);
  EXPECT_EQ(losses[0]["in_map"], false);
  EXPECT_TRUE(losses[0]["key_frame"].is_null());
  EXPECT_NEAR(losses[0]["x"], 84.0, 1e-9);
}

// It was lost beyond the end, came back and stayed lost: odometry knows that it is back.
TEST(Examination, FollowsALostDriveByOdometry) {
  ExaminedDrive drive = straight_drive(150);
  for (std::size_t i = 100; i < 150; ++i) {
    drive.scans[i].T_map_base.translation.x() = 199.0 - static_cast<double>(i);
    drive.scans[i].T_odom_base = T_odom_map() * drive.scans[i].T_map_base;
  }
  set_state(drive, 85, 150, LocalizationState::kLost);
  const Json losses = figures_of(drive)["losses"];
  ASSERT_EQ(losses.size(), 1U);
  EXPECT_EQ(losses[0]["in_map"], true);
  EXPECT_EQ(losses[0]["key_frame"], 29);  // the last one of the map
  EXPECT_NEAR(losses[0]["x"], 72.0, 1e-6);
}

// Where odometry begins anew nothing leads from scan to scan, but the place of the loss is known.
TEST(Examination, TakesNoMotionOverAGapOfOdometry) {
  ExaminedDrive drive = straight_drive();
  for (std::size_t i = 30; i < 60; ++i) {
    drive.scans[i].segment = 1;
    drive.scans[i].T_odom_base.translation += Eigen::Vector3d(500.0, 0.0, 0.0);
  }
  set_state(drive, 30, 35, LocalizationState::kLost);
  const Json figures = figures_of(drive);
  EXPECT_EQ(figures["losses"][0]["in_map"], true);
  EXPECT_EQ(figures["losses"][0]["key_frame"], 14);
  EXPECT_EQ(figures["in_map"]["scans"], 55);  // those that were lost: back from the first behind
  EXPECT_TRUE(figures["odometry"]["jumps"].empty());
  EXPECT_LT(figures["odometry"]["max_m"], 1e-6);
  // From 5 to 19, whose ends are before the gap, and from 35 to 49.
  EXPECT_EQ(figures["odometry"]["motions"], 30);
}

TEST(Examination, FindsNoDifferenceBetweenAGoodMapAndOdometry) {
  const Json odometry = figures_of(straight_drive())["odometry"];
  EXPECT_EQ(odometry["motions"], 45);  // from 5 to 49
  EXPECT_EQ(odometry["rows"].size(), 45U);
  EXPECT_LT(odometry["max_m"], 1e-6);
  EXPECT_LT(odometry["max_deg"], 1e-4);
  EXPECT_TRUE(odometry["jumps"].empty());
}

// The ten motions that begin at 30 to 39 m end behind the jump.
TEST(Examination, FindsWhereThePlaceJumps) {
  ExaminedDrive drive = straight_drive();
  move_left(drive, 40, 0.8);
  const Json odometry = figures_of(drive)["odometry"];
  ASSERT_EQ(odometry["jumps"].size(), 1U);
  EXPECT_NEAR(odometry["jumps"][0]["error_m"], 0.8, 1e-6);
  EXPECT_NEAR(odometry["jumps"][0]["y"], 1.8, 1e-6);
  EXPECT_NEAR(odometry["max_m"], 0.8, 1e-6);
  EXPECT_NEAR(odometry["mean_m"], 10 * 0.8 / 45, 1e-6);
  EXPECT_NEAR(odometry["rmse_m"], 0.8 * std::sqrt(10.0 / 45.0), 1e-6);
}

TEST(Examination, DistinguishesOneJumpFromAnother) {
  ExaminedDrive drive = straight_drive();
  move_left(drive, 20, 0.8);
  move_left(drive, 40, -0.9);
  const auto jumps = jumps_of(motion_differences(drive.scans));
  ASSERT_EQ(jumps.size(), 2U);
  EXPECT_NEAR(jumps[0].metres, 0.8, 1e-6);
  EXPECT_NEAR(jumps[1].metres, 0.9, 1e-6);
  move_left(drive, 20, -0.4);
  move_left(drive, 40, 0.5);
  EXPECT_TRUE(jumps_of(motion_differences(drive.scans)).empty());
  EXPECT_TRUE((MotionDifference{0, 1, 0.0, 2.1}).is_jump());
  EXPECT_FALSE((MotionDifference{0, 1, 0.49, 1.9}).is_jump());
}

TEST(Examination, LeavesOutScansAtRest) {
  ExaminedDrive drive = straight_drive();
  for (int i = 0; i < 20; ++i) {
    drive.scans.push_back(drive.scans.back());
    drive.scans.back().stamp += kNanosecondsPerSecond;
  }
  const Json figures = figures_of(drive);
  EXPECT_EQ(figures["odometry"]["motions"], 45);
  EXPECT_EQ(figures["states"]["following"]["scans"], 75);
  EXPECT_NEAR(figures["states"]["following"]["path_m"], 55.0, 1e-9);
}

TEST(Examination, IsWrittenForAPerson) {
  ExaminedDrive drive = straight_drive();
  set_state(drive, 30, 35, LocalizationState::kLost);
  drive.scans[30].reason = "contradicted";
  const std::string text = examination_text(figures_of(drive), 1);
  for (const char* part :
       {"examined by tuesday_in_monday (tuesday.bag), 60 scans over 59 m: found after 0.5 s and "
        "5.0 m\n",
        "  followed             50 scans      50.0 m\n",
        "  lost                  5 scans       5.0 m\n",
        "  agreement 0.80, a tenth of the scans below 0.80; coverage 0.90, a tenth of the scans "
        "below 0.90\n",
        "  motion over 10 m against odometry: mean 0.000 m, rms 0.000 m, largest 0.000 m (key ",
        "  lost after 3.0 s for 5 scans and 5.0 m, in the map, key frame 14 at 29.0, 1.0: "
        "contradicted\n",
        "  3 of 3 sections of 20 m of the map were passed; least agreement first:\n",
        "    10 to 19             "}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
  }
  for (const char* other : {" 0 to 9 ", " 20 to 29 "}) {
    EXPECT_EQ(text.find(other), std::string::npos) << "only the worst was asked for\n" << text;
  }
}

}  // namespace
}  // namespace lidar_mapping::report
