// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "campaign_case.hpp"
#include "campaign_run.hpp"
#include "error_text.hpp"
#include "evidence_table.hpp"
#include "holds.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::campaign {
namespace {

using front_end::TrackingState;

Pose at(double x, double yaw = 0.0) { return {exp_so3({0.0, 0.0, yaw}), {x, 0.0, 0.0}}; }

TEST(StepChecker, CountsWrongStepsThatAreCalledTracking) {
  StepChecker steps;
  steps.add(at(0.0), at(0.0), TrackingState::kTracking, false);
  steps.add(at(1.0), at(1.29), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().silent, 0U);
  steps.add(at(2.0), at(2.65), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().silent, 1U);
  EXPECT_NEAR(steps.counts().largest_error, 0.36, 1e-9);
  steps.add(at(3.0), at(3.65, 0.02), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().silent, 2U) << "1.1 degrees";
  steps.add(at(4.0), at(9.0), TrackingState::kDegenerate, false);
  EXPECT_EQ(steps.counts().silent, 2U) << "it was said";
}

TEST(StepChecker, LeavesOutWhatIsCalledLostAndComparesAcrossIt) {
  StepChecker steps;
  steps.add(at(0.0), at(0.0), TrackingState::kTracking, false);
  steps.add(at(1.0), at(7.0), TrackingState::kLost, false);
  steps.add(at(2.0), at(2.0), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().silent, 0U);
  steps.add(at(3.0), at(3.0), TrackingState::kLost, false);
  steps.add(at(4.0), at(5.0), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().silent, 1U) << "found again at a wrong place";
  steps.add(at(5.0), at(0.0), TrackingState::kLost, true);
  steps.add(at(6.0), at(1.0), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().silent, 1U) << "a new segment hangs together with nothing before it";
}

TEST(StepChecker, CountsWhatIsDoubtedWithoutNeed) {
  StepChecker steps;
  EXPECT_FALSE(steps.add(at(0.0), at(0.0), TrackingState::kTracking, false));
  const auto error = steps.add(at(1.0), at(1.1), TrackingState::kDoubtful, false);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->metres, 0.1, 1e-9);
  EXPECT_EQ(steps.counts().false_alarms, 1U);
  // A doubtful pose claims to be right within its covariance: the next step leads from it.
  steps.add(at(2.0), at(2.8), TrackingState::kDoubtful, false);
  steps.add(at(3.0), at(3.8), TrackingState::kTracking, false);
  EXPECT_EQ(steps.counts().false_alarms, 1U);
  EXPECT_EQ(steps.counts().wrong, 1U);
  EXPECT_EQ(steps.counts().silent, 0U);
  steps.add(at(4.0), at(4.8), TrackingState::kDegraded, false);
  EXPECT_EQ(steps.counts().false_alarms, 2U);
}

TEST(CheckedStep, IsRightWithinThreeOfItsStandardDeviations) {
  CheckedStep step;
  step.status.evidence.sigma = 0.1;
  step.status.evidence.sigma_angle = 0.01;
  step.error = {0.29, 1.7};
  EXPECT_TRUE(step.is_right());
  step.error = {0.31, 1.7};
  EXPECT_FALSE(step.is_right());
  step.error = {0.29, 1.75};
  EXPECT_FALSE(step.is_right()) << "0.0305 rad";
}

TEST(EvidenceTable, HasALinePerStepAndAColumnPerFigure) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "evidence.csv").string();
  EvidenceTable table(path);
  CheckedStep step;
  step.stamp = 7;
  step.status.probability = 0.5;
  step.error = {0.25, 2.0};
  table.add("a fault=frozen=4,8", {step, step});
  table.close();
  std::ifstream file(path);
  std::string head, line, again, end;
  std::getline(file, head);
  std::getline(file, line);
  std::getline(file, again);
  EXPECT_EQ(line.rfind("\"a fault=frozen=4,8\",7,tracking,0.25,2,0.5,", 0), 0U) << line;
  EXPECT_EQ(line, again);
  EXPECT_FALSE(std::getline(file, end));
  // The case has a comma of its own.
  EXPECT_EQ(std::count(line.begin(), line.end(), ','),
            std::count(head.begin(), head.end(), ',') + 1);
  EXPECT_THROW(EvidenceTable((folder.path() / "none" / "x.csv").string()), FileError);
}

TEST(CampaignCases, AreReadAndWrittenAlike) {
  for (const char* line :
       {"a",
        "b drive=tunnel lidar=vlp16 seed=7 start=3 scan_rate=5 range_noise=0.04 every=4 "
        "undistorted=1 method=VGICP imu=consumer fault=outliers=0.15 fault=imu_gap=2,20"}) {
    EXPECT_EQ(to_line(parse_case(line)), line);
  }
  for (const char* line :
       {"drive=town seed=1", "", "a fog=1", "a every=0", "a seed=x", "a fault=fog", "a drive",
        "a every=1e300", "a seed=-1", "a seed=1e30", "a seed=0.5", "a every=1.5", "a start=1e300",
        "a scan_rate=0", "a range_noise=-1", "a imu=x"}) {
    EXPECT_THROW(parse_case(line), ConfigError) << line;
  }
}

TEST(CampaignCases, OfAFileNameTheLineThatIsWrong) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "cases.txt").string();
  std::ofstream(path) << "# comment\n\nclean\nrain fault=rain=2\n";
  const std::string problem = test::error_text<ConfigError>([&] { read_cases(path); });
  EXPECT_TRUE(test::holds(problem, "line 4"));
  EXPECT_THROW(read_cases(path + "x"), FileError);
}

TEST(CampaignCases, HaveTheDriveThatTheyName) {
  const auto options = drive_options(
      parse_case("a drive=legged lidar=os0 seed=3 start=2 imu=consumer fault=imu_frame fault=wall"),
      10.0);
  EXPECT_EQ(options.drive, "legged");
  EXPECT_EQ(options.lidar, "os0");
  EXPECT_EQ(options.seed, 3U);
  EXPECT_EQ(*options.duration, 12.0);
  EXPECT_EQ(options.imu, "consumer");
  EXPECT_EQ(options.imu_faults.size(), 1U);
  EXPECT_EQ(options.scan_faults.size(), 1U);
}

TEST(CampaignCases, OfASeedAreTheSame) {
  simulation::Random a(5), b(5), c(6);
  EXPECT_EQ(to_line(random_case(a)), to_line(random_case(b)));
  EXPECT_NE(to_line(random_case(a)), to_line(random_case(c)));
  for (int i = 0; i < 50; ++i) {
    const CampaignCase random = random_case(c);
    EXPECT_EQ(to_line(parse_case(to_line(random))), to_line(random));
  }
}

TEST(CampaignRun, CountsScansAndFindsACleanDriveInOrder) {
  const CampaignFigures figures = run_case(parse_case("tunnel drive=tunnel lidar=vlp16 seed=1"), 6);
  EXPECT_EQ(figures.scans, 58U);
  EXPECT_EQ(figures.silent, 0U);
  EXPECT_EQ(figures.lost, 0U);
  EXPECT_LT(figures.largest_error, 0.1);
  EXPECT_GT(figures.cpu_ms, 0.0);
  EXPECT_EQ(figures.steps, 57U);
  EXPECT_LT(figures.squared_error / 57.0, 0.1);
}

// Nothing can be aligned with the truth.
TEST(CampaignRun, RefusesACaseOfLessThanThreeScans) {
  for (const char* line :
       {"a drive=tunnel lidar=vlp16 scan_rate=1", "a drive=tunnel lidar=vlp16 every=1000"}) {
    EXPECT_THROW(run_case(parse_case(line), 1.5), ConfigError) << line;
  }
}

TEST(CampaignRun, GivesTheImuOfACaseToTheFrontEnd) {
  const std::string line = "by_hand drive=handheld lidar=vlp16 seed=1";
  const CampaignFigures without = run_case(parse_case(line), 4);
  const CampaignFigures with = run_case(parse_case(line + " imu=consumer"), 4);
  EXPECT_EQ(with.scans, without.scans);
  EXPECT_NE(with.ape, without.ape);
  EXPECT_LT(with.ape, 0.05);
  EXPECT_NEAR(with.path_length, without.path_length, 1e-9);
}

}  // namespace
}  // namespace lidar_mapping::campaign
