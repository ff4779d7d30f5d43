// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/csv.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "examined_drive.hpp"
#include "holds.hpp"
#include "localization/localize_files.hpp"
#include "localization/localize_summary.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

using localization::LocalizationState;
using test::holds;
using test::TemporaryFolder;

const GeodeticDatum kKarlsruhe{49.0, 8.4, 110.0};

LocalizedScan scan_with(LocalizationState state, Stamp stamp) {
  LocalizedScan scan;
  scan.result.state = state;
  scan.result.stamp = stamp;
  scan.result.reason = "the map shows it, all of it";
  scan.result.T_map_base.translation = {3.0, 4.0, 0.5};
  scan.result.covariance = diagonal_covariance(0.02, 0.001);
  scan.result.probability = 0.999;
  scan.result.agreement = 0.8;
  scan.result.coverage = 0.9;
  scan.path = to_seconds(stamp);
  scan.T_odom_base.translation = {scan.path, 7.0, 0.0};
  scan.segment = 2;
  scan.seconds = 0.002;
  return scan;
}

/// The first scan with a pose, in which the search ended.
LocalizedScan found_scan(Stamp stamp) {
  LocalizedScan scan = scan_with(LocalizationState::kFollowing, stamp);
  scan.seconds = 0.003;
  return scan;
}

/// Searched for two seconds, then followed, then beside the map.
std::vector<LocalizedScan> short_drive() {
  return {scan_with(LocalizationState::kSearching, 1'000'000'000), found_scan(3'000'000'001),
          scan_with(LocalizationState::kFollowing, 4'000'000'000),
          scan_with(LocalizationState::kBesideMap, 5'000'000'000)};
}

/// The rows of a table by the names of its columns.
std::vector<std::map<std::string, std::string>> rows_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = csv_cells(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = csv_cells(line);
    EXPECT_EQ(cells.size(), names.size()) << line;
    rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), names.size()); ++i) {
      rows.back()[names[i]] = cells[i];
    }
  }
  return rows;
}

TEST(LocalizationCsv, HasARowForEachScanWithAllDigitsOfItsStamp) {
  const auto rows = rows_of(localization_csv(short_drive(), std::nullopt));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].at("state"), "searching");
  EXPECT_EQ(rows[1].at("stamp"), "3.000000001");
  EXPECT_EQ(rows[1].at("state"), "following");
  EXPECT_EQ(rows[3].at("state"), "beside_map");
  EXPECT_EQ(rows[1].at("reason"), "the map shows it, all of it");
  EXPECT_EQ(rows[1].count("latitude_deg"), 0U);
  EXPECT_EQ(rows[0].at("path"), "1.0000");
  EXPECT_EQ(rows[0].at("segment"), "2");
}

TEST(LocalizationCsv, LeavesPosesEmptyWhereNoneIsClaimed) {
  const auto rows = rows_of(localization_csv(short_drive(), kKarlsruhe));
  for (const char* name :
       {"x", "y", "z", "qx", "qw", "stddev_x", "stddev_yaw_deg", "latitude_deg", "northing"}) {
    EXPECT_EQ(rows[0].at(name), "") << name;
    EXPECT_NE(rows[1].at(name), "") << name;
    EXPECT_NE(rows[3].at(name), "") << name;
  }
  EXPECT_NEAR(std::stod(rows[1].at("x")), 3.0, 1e-3);
  EXPECT_NEAR(std::stod(rows[1].at("stddev_z")), 0.02, 1e-3);
  EXPECT_NEAR(std::stod(rows[1].at("stddev_yaw_deg")), 0.0573, 1e-3);
}

TEST(LocalizationCsv, HasPositionsOnTheEarthWhereTheMapHasADatum) {
  const auto row = rows_of(localization_csv(short_drive(), kKarlsruhe))[1];
  // Metres per degree on the WGS 84 ellipsoid at 49 degrees north.
  EXPECT_NEAR(std::stod(row.at("latitude_deg")), 49.0 + 4.0 / 111'210.0, 1e-7);
  EXPECT_NEAR(std::stod(row.at("longitude_deg")), 8.4 + 3.0 / 73'170.0, 1e-7);
  EXPECT_NEAR(std::stod(row.at("altitude_m")), 110.5, 1e-2);
  EXPECT_NEAR(std::stod(row.at("easting")), 456'121.0, 50.0);
  EXPECT_NEAR(std::stod(row.at("northing")), 5'427'650.0, 150.0);
}

TEST(LocalizationFiles, HoldThePosesInATrajectory) {
  const TemporaryFolder folder;
  write_localization(folder.path() / "new", short_drive(), std::nullopt);
  const Trajectory poses = read_trajectory(folder.path() / "new" / "trajectory/localized.tum");
  ASSERT_EQ(poses.poses.size(), 3U);  // all but the one that was searched for
  EXPECT_EQ(poses.poses[0].stamp, 3'000'000'001);
  EXPECT_TRUE(test::near(poses.poses[0].pose.translation, Eigen::Vector3d(3.0, 4.0, 0.5), 1e-6));
  const auto odometry =
      read_trajectory(folder.path() / "new" / "trajectory/laser_odom_scans.tum").poses;
  ASSERT_EQ(odometry.size(), 4U);
  EXPECT_EQ(odometry[1].stamp, 3'000'000'001);
  EXPECT_TRUE(test::near(odometry[3].pose.translation, Eigen::Vector3d(5.0, 7.0, 0.0), 1e-6));
  EXPECT_THROW(check_new_folder(folder.path() / "new"), FileError);
  EXPECT_NO_THROW(check_new_folder(folder.path() / "another"));
}

// With a datum there are more columns.
TEST(LocalizationFiles, ExamineAMap) {
  const TemporaryFolder folder;
  const std::vector<LocalizedScan> drive = short_drive();
  const auto expect_to_be_read = [&](const std::optional<GeodeticDatum>& datum) {
    write_localization(folder.path(), drive, datum);
    const auto scans = report::read_examined_scans(folder.path());
    ASSERT_EQ(scans.size(), drive.size());
    for (std::size_t i = 0; i < scans.size(); ++i) {
      EXPECT_EQ(scans[i].stamp, drive[i].result.stamp);
      EXPECT_EQ(scans[i].state, drive[i].result.state);
      EXPECT_EQ(scans[i].reason, drive[i].result.reason);
      EXPECT_NEAR(scans[i].path, drive[i].path, 1e-4);
      EXPECT_EQ(scans[i].segment, 2U);
      EXPECT_NEAR(scans[i].agreement, 0.8, 1e-9);
      EXPECT_TRUE(test::near(scans[i].T_odom_base, drive[i].T_odom_base, 1e-6));
    }
    EXPECT_TRUE(test::near(scans[1].T_map_base, drive[1].result.T_map_base, 1e-4));
  };
  expect_to_be_read(std::nullopt);
  expect_to_be_read(kKarlsruhe);
}

TEST(LocalizationFiles, DoNotLieInTheNewSession) {
  const TemporaryFolder folder;
  const std::filesystem::path session = folder.path() / "session";
  EXPECT_THROW(check_session_folder(session, session), FileError);
  EXPECT_THROW(check_session_folder(session, session / ""), FileError);
  EXPECT_THROW(check_session_folder(session, session / "results"), FileError);
  EXPECT_NO_THROW(check_session_folder(session, folder.path() / "results"));
  EXPECT_NO_THROW(check_session_folder(folder.path() / "results/session", folder.path()));
  std::ofstream(session) << "mine";
  EXPECT_THROW(check_session_folder(session, folder.path() / "results"), FileError);
}

TEST(ExtensionText, SaysWhatWasAddedAndWhatWasLeftOut) {
  pipeline::ExtensionReport report;
  report.extension.sections.resize(1);
  report.extension.sections[0].new_path_length = 84.2;
  report.extension.sections[0].ties.resize(6);
  report.extension.omitted.too_short = 8.4;
  report.key_frames = 57;
  report.largest_move = 0.0031;
  EXPECT_EQ(extension_text(report, "town"),
            "added to the map: 84 m of new path in 1 section; 57 key frames including those of the "
            "adjacent known path, with 6 constraints to the map\nleft out: 8 m in sections shorter "
            "than 10 m\nthe key frames of the map moved by 0.003 m at most\ntown\n");
}

TEST(ExtensionText, SaysWhyNoSessionIsWritten) {
  pipeline::ExtensionReport report;
  EXPECT_EQ(extension_text(report, "town"),
            "nothing of the drive is new to the map, so no session is written\n");
  report.extension.omitted.never_found = 120.0;
  report.extension.omitted.not_tied = 40.0;
  EXPECT_EQ(extension_text(report, "town"),
            "nothing could be added to the map, so no session is written\n"
            "left out: 120 m that odometry does not connect to any place found in the map; 40 m "
            "with fewer than 3 consistent constraints to the map\n");
}

TEST(LocalizationFigures, CountStatesAndSayWhenThePlaceWasFound) {
  const json::Json figures = localization_figures(short_drive());
  EXPECT_EQ(figures["scans"], 4);
  EXPECT_EQ(figures["states"]["following"], 2);
  EXPECT_EQ(figures["states"]["lost"], 0);
  EXPECT_NEAR(figures["found_after"]["seconds"], 2.0, 1e-6);
  EXPECT_NEAR(figures["found_after"]["metres"], 3.0, 1e-6);
  EXPECT_NEAR(figures["mean_agreement"], 0.8, 1e-9);
  EXPECT_NEAR(figures["milliseconds"]["searching"]["mean"], 2.5, 1e-9);  // of two scans
  EXPECT_NEAR(figures["milliseconds"]["following"]["mean"], 2.0, 1e-9);
  const std::string text = localization_text(figures);
  EXPECT_TRUE(holds(text, "found after 2.0 s and 3.0 m"));
  EXPECT_TRUE(holds(text, "50.0 % followed, 25.0 % outside the map, 0.0 % lost, 25.0 % searching"));
}

TEST(LocalizationFigures, SayNothingOfAPlaceThatWasNotFound) {
  const json::Json figures =
      localization_figures({scan_with(LocalizationState::kSearching, 1'000'000'000)});
  EXPECT_TRUE(figures["found_after"].is_null());
  EXPECT_FALSE(holds(localization_text(figures), "found after"));
}

}  // namespace
}  // namespace lidar_mapping::tools
