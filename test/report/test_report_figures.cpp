// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "holds.hpp"
#include "report_figures.hpp"
#include "run_record.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::report {
namespace {

using session::Session;
using test::holds;

/// Ten metres straight on, a key frame each; the map is shifted against odometry half way.
class ReportFigures : public testing::Test {
 protected:
  ReportFigures() {
    for (KeyFrameIndex index = 0; index < 11; ++index) {
      KeyFrame key_frame;
      key_frame.index = index;
      key_frame.stamp = 1'000'000'000LL * (index + 1);
      key_frame.T_odom_base.translation.x() = index;
      auto cloud = std::make_shared<PointCloud>();
      cloud->points.push_back({1.0F, 0.0F, 0.0F, 0.0F});
      key_frame.cloud = cloud;
      session_.add_key_frame(key_frame);
      Pose T_map_base = key_frame.T_odom_base;
      if (index >= 5) T_map_base.translation.z() = 0.25;
      poses_.poses.push_back({index, key_frame.stamp, T_map_base});
    }
    poses_.revision = 1;
    session::RevisionRecord record;
    record.revision = 1;
    session_.set_poses(poses_, record);
  }

  Loop loop(KeyFrameIndex from, KeyFrameIndex to, double off) {
    Loop loop;
    loop.from = from;
    loop.to = to;
    loop.T_from_to = poses_.poses[from].T_map_base.inverse() * poses_.poses[to].T_map_base;
    loop.T_from_to.translation.y() += off;
    return loop;
  }

  test::TemporaryFolder folder_;
  Session session_ = Session::create_in(folder_.path() / "session");
  KeyFramePoses poses_;
};

TEST_F(ReportFigures, GiveTheDistanceBetweenOdometryAndMap) {
  const json::Json figures = trajectory_figures(report_input(session_));
  EXPECT_EQ(figures["rows"].size(), 11U);
  EXPECT_NEAR(figures["odometry_max_m"], 0.25, 1e-9);
  EXPECT_NEAR(figures["odometry_max_vertical_m"], 0.25, 1e-9);
}

TEST_F(ReportFigures, GiveTheResidualOfEveryLoopThatIsUsed) {
  session_.add_loop(loop(0, 8, 0.03));
  session_.add_loop(loop(1, 9, 0.01));
  session_.add_loop(loop(2, 10, 2.0));
  LoopVerdict refused;
  refused.from = 2;
  refused.to = 10;
  refused.verdict = Verdict::kRefused;
  refused.reason = "the graph leaves it out";
  session_.add_verdict(refused);
  const json::Json figures = loop_figures(report_input(session_));
  EXPECT_EQ(figures["used"], 2);
  EXPECT_EQ(figures["dropped_by_graph"], 1);
  EXPECT_NEAR(figures["max_residual_m"], 0.03, 1e-9);
  // Odometry knows nothing of the step in height.
  EXPECT_NEAR(figures["candidates"][0]["odometry_residual_m"], std::hypot(0.25, 0.03), 1e-9);
}

TEST_F(ReportFigures, FindTheLongestPathWithoutAConstraint) {
  session_.add_loop(loop(0, 3, 0.0));
  const auto graph = solved_graph(session_);
  const auto deviations = back_end::key_frame_deviations(*graph->problem(true));
  const ReportInput input = report_input(session_);
  const json::Json figures = uncertainty_figures(input, *graph, deviations);
  EXPECT_NEAR(figures["longest_without_constraint"]["length_m"], 7.0, 0.1);
  EXPECT_NEAR(figures["longest_without_constraint"]["begin_m"], 3.0, 0.1);
  EXPECT_GT(figures["largest"]["sigma_m"], 0.0);
  EXPECT_EQ(figures["rows"].size(), input.poses.poses.size());
  EXPECT_EQ(figures["not_tied"], 0);
  EXPECT_EQ(figures["doubtful"], 0);
}

// Positions were received, but no datum tells where they are: the graph does not use them.
TEST_F(ReportFigures, CountNoGnssAsAConstraintThatTheGraphDoesNotUse) {
  GnssPosition position;
  position.stamp = poses_.poses[5].stamp;
  position.p_enu_antenna = {5.0, 0.0, 0.0};
  session_.add_gnss(position);
  const auto graph = solved_graph(session_);
  const auto gap = [&] {
    return uncertainty_figures(report_input(session_), *graph, {})["longest_without_constraint"];
  };
  EXPECT_NEAR(gap()["length_m"], 10.0, 0.1);
  session_.set_datum({49.0, 8.4, 110.0});
  EXPECT_NEAR(gap()["length_m"], 5.0, 0.1);
}

/// A minute of another vehicle a day before, 300 m away, whose odometry begins somewhere else. Its
/// scans are doubtful from the third second on.
void add_other_drive(Session& session, KeyFramePoses& poses) {
  for (const KeyFramePose& pose : poses.poses) {
    session.add_odometry({pose.stamp, pose.T_map_base, 0});
  }
  session::RevisionRecord record;
  record.revision = 2;
  for (KeyFrameIndex i = 0; i < 7; ++i) {
    KeyFrame key_frame;
    key_frame.index = 11 + i;
    key_frame.segment = 1;
    key_frame.stamp = from_seconds(i * 10.0 - 86'400.0);
    key_frame.T_odom_base.translation = {900.0 + 2.0 * i, 70.0, 0.0};
    session.add_key_frame(key_frame);
    session.add_odometry({key_frame.stamp, key_frame.T_odom_base, 1});
    session::ScanRecord scan;
    scan.stamp = key_frame.stamp;
    scan.state = i == 3 || i == 4 ? "degraded" : "tracking";
    session.add_scan(scan);
    Pose T_map_base;
    T_map_base.translation = {300.0 + 2.0 * i, 0.0, 0.0};
    poses.poses.push_back({key_frame.index, key_frame.stamp, T_map_base});
  }
  poses.revision = 2;
  session.set_poses(poses, record);
}

TEST_F(ReportFigures, CountMergedDrivesOneByOne) {
  add_other_drive(session_, poses_);
  const ReportInput input = report_input(session_);
  const json::Json drive = drive_figures(input);
  EXPECT_NEAR(drive["length_m"], 10.0 + 0.03 + 12.0, 0.02);
  EXPECT_EQ(drive["seconds"], 10.0 + 60.0);
  EXPECT_NEAR(trajectory_figures(input)["odometry_max_m"], 0.25, 1e-9);
  const auto graph = solved_graph(session_);
  const json::Json gap = uncertainty_figures(input, *graph, {})["longest_without_constraint"];
  EXPECT_NEAR(gap["length_m"], 12.0, 0.01) << "the path of a drive, not that of both";
}

TEST_F(ReportFigures, PlaceADoubtfulSectionInItsDrive) {
  add_other_drive(session_, poses_);
  const json::Json doubt = doubt_figures(report_input(session_), *solved_graph(session_));
  for (const json::Json& section : doubt["sections"]) {
    if (section["kind"] != "degraded") continue;
    EXPECT_GE(section["rows"][0], 11 + 2);
    EXPECT_LE(section["rows"][1], 11 + 4);
  }
  EXPECT_FALSE(doubt["sections"].empty());
}

TEST_F(ReportFigures, HaveALineForEachKeyFrame) {
  const auto graph = solved_graph(session_);
  const auto deviations = back_end::key_frame_deviations(*graph->problem(true));
  std::istringstream table(key_frame_table(report_input(session_), deviations));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line,
            "key_frame,stamp_ns,x,y,z,path_length_m,part,doubtful,sigma_first_m,sigma_first_deg,"
            "sigma_previous_m,sigma_previous_deg");
  std::getline(table, line);
  EXPECT_TRUE(holds(line, ",0,no,0.000000,0.000000,0.000000,0.000000"));
  std::size_t lines = 1;
  while (std::getline(table, line)) {
    ++lines;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 11) << line;
    EXPECT_FALSE(holds(line, "inf"));
  }
  EXPECT_EQ(lines, deviations.size());
}

TEST_F(ReportFigures, NameTheScansThatWereNotTracked) {
  for (int i = 0; i < 10; ++i) {
    session::ScanRecord scan;
    scan.stamp = 100'000'000LL * (i + 1);
    scan.state = i == 4 || i == 5 ? "lost" : "tracking";
    scan.scans_dropped = i == 9 ? 3 : 0;
    session_.add_scan(scan);
  }
  const json::Json figures = scan_figures(report_input(session_));
  EXPECT_EQ(figures["dropped"], 3);
  EXPECT_EQ(figures["states"]["lost"], 2);
  ASSERT_EQ(figures["sections"].size(), 1U);
  EXPECT_EQ(figures["sections"][0]["scans"], 2);
  EXPECT_NEAR(figures["sections"][0]["begin_s"], 0.4, 1e-9);
}

// The front end was restarted at the third scan, and counts from 0 again.
TEST_F(ReportFigures, RememberDroppedScansAfterARestart) {
  Stamp stamp = 0;
  for (const int dropped : {0, 4, 0, 1}) {
    session::ScanRecord scan;
    scan.stamp = stamp += 100'000'000;
    scan.state = "tracking";
    scan.scans_dropped = dropped;
    session_.add_scan(scan);
  }
  EXPECT_EQ(scan_figures(report_input(session_))["dropped"], 4);
}

// Two positions do not tell where a map lies that was never moved to East-North-Up.
TEST_F(ReportFigures, CompareWithGnssOnlyWhereItCanBeAligned) {
  const auto add_position = [this](KeyFrameIndex index) {
    GnssPosition position;
    position.stamp = poses_.poses[index].stamp;
    position.p_enu_antenna = {500.0, 70.0 + index, 3.0};
    session_.add_gnss(position);
  };
  const auto figures = [this] {
    return gnss_figures(report_input(session_), *solved_graph(session_));
  };
  add_position(0);
  add_position(10);
  EXPECT_EQ(figures()["positions"], 0);
  EXPECT_EQ(figures()["p95_horizontal_m"], 0.0);
  add_position(5);
  EXPECT_EQ(figures()["positions"], 3);
  EXPECT_LT(figures()["p95_horizontal_m"], 0.5);
}

TEST_F(ReportFigures, CompareWithTheTruthAfterAlignment) {
  Trajectory truth;
  for (const KeyFramePose& pose : poses_.poses) {
    Pose moved = pose.T_map_base;
    moved.translation += Eigen::Vector3d(100.0, 50.0, 1.0);
    moved.translation.y() += 0.02 * std::sin(1.0 + pose.index);
    truth.poses.push_back({pose.stamp, moved});
  }
  const json::Json figures = truth_figures(report_input(session_, truth));
  EXPECT_EQ(figures["poses"], 11);
  EXPECT_GT(figures["ape_rmse_m"], 0.002);
  EXPECT_LT(figures["ape_max_m"], 0.03);
  EXPECT_EQ(figures["rpe_delta_m"], 10.0);
  EXPECT_TRUE(truth_figures(report_input(session_)).is_null());
}

TEST_F(ReportFigures, RefuseATruthOfAnotherTime) {
  Trajectory truth;
  for (int i = 0; i < 5; ++i) truth.poses.push_back({from_seconds(9e5 + i), Pose::Identity()});
  const std::string problem =
      test::error_text<InputError>([&] { truth_figures(report_input(session_, truth)); });
  EXPECT_TRUE(holds(problem, "check the clocks of both")) << problem;
}

TEST_F(ReportFigures, SayThatATruthHasGaps) {
  Trajectory truth;
  for (int i = 0; i < 12; ++i) {
    truth.poses.push_back({from_seconds(0.5 + i), Pose{{1, 0, 0, 0}, {i - 0.5, 0.0, 0.0}}});
  }
  const std::string problem =
      test::error_text<InputError>([&] { truth_figures(report_input(session_, truth)); });
  EXPECT_TRUE(holds(problem, "11 lie in gaps of the true trajectory longer than 0.5 s; give"))
      << problem;
}

TEST_F(ReportFigures, GiveNoRelativeErrorForAPathThatIsTooShort) {
  Trajectory truth;
  for (std::size_t i = 0; i < 6; ++i) {
    truth.poses.push_back({poses_.poses[i].stamp, poses_.poses[i].T_map_base});
  }
  const json::Json figures = truth_figures(report_input(session_, truth));
  EXPECT_EQ(figures["poses"], 6);
  EXPECT_EQ(figures["left_out"]["outside"], 5);
  EXPECT_EQ(figures["rpe_count"], 0);
  for (const char* name : {"rpe_rmse_m", "rpe_rmse_deg", "kitti_translation_percent"}) {
    EXPECT_TRUE(figures[name].is_null()) << name;
  }
}

TEST_F(ReportFigures, NameTheOriginOfTheMap) {
  EXPECT_TRUE(origin_figures(report_input(session_))["recording"].is_null());
  RunRecord record;
  record.software = "lidar_mapping 0.1.0";
  record.command = "map_bag drive.bag -o town";
  record.files = {{"drive.bag", 12345, "ab"}};
  write_run_record(session_.directory(), record);
  session_.set_datum({49.0, 8.4, 110.0});
  const json::Json origin = origin_figures(report_input(session_));
  EXPECT_EQ(origin["recording"][0]["name"], "drive.bag");
  EXPECT_EQ(origin["command"], record.command);
  EXPECT_TRUE(holds(origin["coordinates"].get<std::string>(), "49.0000000"));
  std::filesystem::create_directory(session_.directory() / "map");
  std::ofstream(session_.directory() / "map" / "map.yaml")
      << "points: 3\nmin: [-1.5000, 2.0000, 0.0000]\nmax: [7.0000, 8.0000, 9.0000]\n";
  const json::Json products = product_figures(report_input(session_));
  EXPECT_EQ(products["map_min_m"][0], -1.5);
  EXPECT_EQ(products["map_max_m"][2], 9.0);
}

TEST_F(ReportFigures, RefuseARecordThatIsDamaged) {
  write_run_record(session_.directory(), {});
  const std::string whole = test::content_of(session_.directory() / "run.json");
  const std::string begin = "\"begin_ns\": 0";
  for (const char* number : {"1e300", "true", "18446744073709551615", "1e999", "\"0\""}) {
    std::string text = whole;
    text.replace(text.find(begin), begin.size(), std::string("\"begin_ns\": ") + number);
    std::ofstream(session_.directory() / "run.json") << text;
    const std::string problem =
        test::error_text<InputError>([this] { read_run_record(session_.directory()); });
    EXPECT_TRUE(holds(problem, "run.json")) << number;
  }
}

// A file's name may hold any bytes.
TEST_F(ReportFigures, TakeNamesThatAreNoUtf8) {
  RunRecord record;
  record.command =
      "map_bag stra\xDF"
      "e.bag";
  write_run_record(session_.directory(), record);
  EXPECT_EQ(read_run_record(session_.directory())->command, "map_bag stra\uFFFDe.bag");
}

}  // namespace
}  // namespace lidar_mapping::report
