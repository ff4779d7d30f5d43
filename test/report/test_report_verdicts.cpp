// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "examined_example.hpp"
#include "report_examination.hpp"
#include "report_figures.hpp"

namespace lidar_mapping::report {
namespace {

json::Json thickness(double median, double within, const json::Json& ratio) {
  return {{"cells", 100},
          {"median_m", median},
          {"median_within_m", within},
          {"median_ratio_to_noise", ratio}};
}

json::Json good_report() {
  return {{"thickness",
           {{"walls", thickness(0.014, 0.013, 1.05)}, {"ground", thickness(0.004, 0.004, 1.1)}}},
          {"misalignments", json::Json::array({{{"along_m", 0.01},
                                                {"left_m", 0.01},
                                                {"up_m", 0.0},
                                                {"yaw_deg", 0.0},
                                                {"size_m", 0.014}}})},
          {"loops",
           {{"used", 10},
            {"dropped_by_graph", 0},
            {"refused_or_undecided", 3},
            {"max_residual_m", 0.05}}},
          {"gnss",
           {{"positions", 5},
            {"used_by_graph", true},
            {"median_horizontal_m", 0.02},
            {"p95_horizontal_m", 0.05},
            {"median_stated_sigma_m", 0.05}}},
          {"trajectory", {{"odometry_max_m", 0.3}, {"odometry_max_vertical_m", 0.1}}},
          {"drive", {{"key_frames", 50}, {"length_m", 1000.0}}},
          {"scans", {{"scans", 50}, {"dropped", 0}, {"states", {{"tracking", 50}}}}},
          {"uncertainty",
           {{"largest", {{"sigma_m", 0.1}, {"key_frame", 49}, {"x", 12.0}, {"y", -3.5}}},
            {"largest_step", {{"sigma_m", 0.02}, {"key_frame", 7}, {"x", 1.0}, {"y", 2.0}}},
            {"not_tied", 0},
            {"doubtful", 0},
            {"longest_without_constraint", {{"length_m", 10.0}, {"begin_m", 0.0}}}}},
          {"doubt", {{"sections", json::Json::array()}, {"warnings", json::Json::array()}}},
          {"examinations", json::Json::array()},
          {"truth", nullptr}};
}

json::Json section(bool trusted, const json::Json& error) {
  return {{"kind", "degenerate"},
          {"begin_s", 12.3},
          {"end_s", 40.1},
          {"error_m", error},
          {"trusted", trusted}};
}

/// The entry `key` of the line with this name.
json::Json entry(const json::Json& report, const std::string& name, const char* key) {
  for (const json::Json& line : verdicts(report)) {
    if (line["name"] == name) return line[key];
  }
  ADD_FAILURE() << "no line " << name;
  return nullptr;
}

json::Json verdict_on(const json::Json& report, const std::string& name) {
  return entry(report, name, "good");
}

TEST(ReportVerdicts, AreGoodForAGoodMap) {
  for (const json::Json& line : verdicts(good_report())) {
    EXPECT_EQ(line["good"], true) << line.dump();
    EXPECT_NE(line["limit"], "") << "a verdict says what is good: " << line.dump();
  }
}

TEST(ReportVerdicts, SayWhereToLook) {
  json::Json report = good_report();
  report["thickness"]["walls"] = thickness(0.03, 0.013, nullptr);
  report["misalignments"][0]["up_m"] = -0.06;
  report["loops"]["dropped_by_graph"] = 1;
  report["gnss"]["p95_horizontal_m"] = 0.5;
  report["trajectory"]["odometry_max_m"] = 11.0;
  report["scans"]["dropped"] = 2;
  report["uncertainty"]["largest"]["sigma_m"] = 0.6;
  for (const char* name : {"Walls", "Repeated passes", "Loops", "GNSS", "Odometry against the map",
                           "Scans", "Pose uncertainty"}) {
    EXPECT_EQ(verdict_on(report, name), false) << name;
  }
  EXPECT_EQ(verdict_on(report, "Ground"), true);
}

TEST(ReportVerdicts, CannotBeGoodWhereTheMotionWasNotObserved) {
  json::Json report = good_report();
  report["doubt"]["sections"].push_back(section(true, 0.2));
  EXPECT_EQ(verdict_on(report, "Motion observed"), true);
  report["doubt"]["sections"].push_back(section(false, 20.0));
  report["verdicts"] = verdicts(report);
  EXPECT_EQ(verdict_on(report, "Motion observed"), false);
  EXPECT_EQ(report["verdicts"].back()["value"], "not between 12.3 and 40.1 s, error 20.0 m");
  EXPECT_EQ(overall_verdict(report), "Look at: Motion observed");
  report["doubt"]["sections"].push_back(section(false, nullptr));
  EXPECT_EQ(verdicts(report).back()["value"], "lost at 12.3 s, parts not connected");
}

TEST(ReportVerdicts, SayWhereThePosesAreKnownLeast) {
  json::Json report = good_report();
  const auto value = [&] { return entry(report, "Pose uncertainty", "value"); };
  const std::string known =
      "standard deviation up to 0.10 m from the first key frame (key frame 49 at 12.0, -3.5), "
      "up to 0.02 m from a neighbour (key frame 7 at 1.0, 2.0)";
  EXPECT_EQ(value(), known);
  report["uncertainty"]["doubtful"] = 2;
  EXPECT_EQ(value(), known + "; 2 are doubtful");
  EXPECT_EQ(verdict_on(report, "Pose uncertainty"), false);
  report["uncertainty"]["doubtful"] = 0;
  report["uncertainty"]["not_tied"] = 5;
  EXPECT_EQ(value(), known + "; 5 key frames are not connected to the first");
  report["verdicts"] = verdicts(report);
  EXPECT_EQ(overall_verdict(report), "Look at: Pose uncertainty");
  report["uncertainty"]["largest"] = nullptr;
  EXPECT_EQ(value(), "not known");
}

// Nothing measured is neither good nor bad.
TEST(ReportVerdicts, SayNothingOfWhatIsNotThere) {
  json::Json report = good_report();
  report["misalignments"] = json::Json::array();
  report["gnss"]["positions"] = 0;
  report["loops"] = {
      {"used", 0}, {"dropped_by_graph", 0}, {"refused_or_undecided", 0}, {"max_residual_m", 0.0}};
  for (const char* name : {"Repeated passes", "GNSS", "Loops"}) {
    EXPECT_TRUE(verdict_on(report, name).is_null()) << name;
  }
}

// Without loops and GNSS the map is the odometry: that both agree says nothing.
TEST(ReportVerdicts, DoNotPraiseOdometryForAgreeingWithItself) {
  json::Json report = good_report();
  report["loops"]["used"] = 0;
  report["gnss"]["positions"] = 0;
  report["trajectory"]["odometry_max_m"] = 0.0;
  EXPECT_TRUE(verdict_on(report, "Odometry against the map").is_null());
  report["gnss"]["positions"] = 5;
  EXPECT_EQ(verdict_on(report, "Odometry against the map"), true);
  report["gnss"]["used_by_graph"] = false;
  EXPECT_TRUE(verdict_on(report, "Odometry against the map").is_null());
}

TEST(ReportVerdicts, AreNotGoodWhereAnotherDriveWasLost) {
  json::Json report = good_report();
  ExaminedDrive drive = straight_drive();
  report["examinations"].push_back(examination_figures(drive, straight_map()));
  EXPECT_EQ(verdict_on(report, "Examination by tuesday_in_monday"), true);
  set_state(drive, 30, 31, localization::LocalizationState::kLost);
  drive.name = "friday_in_monday";
  report["examinations"].push_back(examination_figures(drive, straight_map()));
  report["verdicts"] = verdicts(report);
  EXPECT_EQ(overall_verdict(report), "Look at: Examination by friday_in_monday");
}

TEST(ReportVerdicts, AreSummedUp) {
  json::Json report = good_report();
  report["verdicts"] = verdicts(report);
  EXPECT_EQ(overall_verdict(report), "Good: nothing that has to be checked");
  report["scans"]["dropped"] = 2;
  report["uncertainty"]["largest"]["sigma_m"] = 0.6;
  report["misalignments"] = json::Json::array();
  report["verdicts"] = verdicts(report);
  EXPECT_EQ(overall_verdict(report),
            "Look at: Scans, Pose uncertainty; no place was driven twice, so only local quality "
            "could be judged");
  report["drive"]["key_frames"] = 0;
  EXPECT_EQ(overall_verdict(report), "There is no map: the session has no key frames");
}

TEST(ReportVerdicts, SayWhatTheTruthDoesNotCover) {
  json::Json report = good_report();
  report["truth"] = {{"ape_rmse_m", 0.01},
                     {"ape_max_m", 0.02},
                     {"rpe_delta_m", 10.0},
                     {"rpe_count", 0},
                     {"rpe_rmse_m", nullptr},
                     {"rpe_rmse_deg", nullptr},
                     {"left_out", {{"outside", 0}, {"in_gaps", 7}}}};
  EXPECT_EQ(entry(report, "Against the truth", "note"),
            "after rigid alignment; no RPE: the path is shorter than 10 m; of the key frames 7 lie "
            "in gaps of the truth longer than 0.5 s");
  report["truth"]["rpe_count"] = 3;
  report["truth"]["rpe_rmse_m"] = 0.0015;
  report["truth"]["rpe_rmse_deg"] = 0.25;
  report["truth"]["left_out"]["in_gaps"] = 0;
  EXPECT_EQ(entry(report, "Against the truth", "note"),
            "after rigid alignment; RPE over 10 m 1.5 mm, 0.250 deg");
}

TEST(ReportVerdicts, JudgeNoScansWhereNoneWereRecorded) {
  json::Json report = good_report();
  report["scans"] = {{"scans", 0}, {"dropped", 0}, {"states", json::Json::object()}};
  EXPECT_TRUE(verdict_on(report, "Scans").is_null());
}

}  // namespace
}  // namespace lidar_mapping::report
