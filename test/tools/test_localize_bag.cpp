// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "json.hpp"
#include "localized_drives.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::Words;

using LocalizeBag = test::LocalizedDrives;

TEST_F(LocalizeBag, FindsADriveOfAnotherDayByAnotherSensor) {
  const auto errors = errors_of("other_day", localized_day());
  EXPECT_GT(errors.translation_m.count, 200U);
  EXPECT_LT(errors.translation_m.max, 0.5);
  EXPECT_LT(errors.rotation_deg.max, 2.0);
  EXPECT_LT(errors.translation_m.rmse, 0.05);
}

TEST_F(LocalizeBag, ExaminesTheMap) {
  const fs::path file = root() / "quality.json";
  ASSERT_EQ(run("map_quality", {map(), "--examined-by", localized_day(), "--json", file}), 0);
  EXPECT_TRUE(has_said("examined by day (other_day.bag), "));
  const json::Json figures = json::Json::parse(content_of(file));
  ASSERT_EQ(figures["examinations"].size(), 1U);
  const json::Json& drive = figures["examinations"][0];
  EXPECT_GT(drive["states"]["following"]["scans"], 200);
  EXPECT_GT(drive["in_map"]["followed"]["path_m"], 50.0);
  EXPECT_TRUE(drive["losses"].empty()) << drive["losses"];
  EXPECT_GT(drive["odometry"]["motions"], 50);
  EXPECT_LT(drive["odometry"]["max_m"], 0.3);
  const json::Json& verdict = figures["verdicts"].back();
  EXPECT_EQ(verdict["name"], "Examination by day");
  EXPECT_EQ(verdict["good"], true) << verdict;
}

TEST_F(LocalizeBag, FindsADriveInTheOppositeDirection) {
  const fs::path output = root() / "back";
  ASSERT_EQ(localize(way_back(), output), 0);
  const auto errors = errors_of("way_back", output);
  EXPECT_GT(errors.translation_m.count, 150U);
  EXPECT_LT(errors.translation_m.max, 0.5);
  EXPECT_LT(errors.rotation_deg.max, 2.0);
  EXPECT_LT(errors.translation_m.rmse, 0.05);
}

TEST_F(LocalizeBag, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto with_threads = [&](const std::string& threads) {
    const fs::path output = root() / ("threads_" + threads);
    EXPECT_EQ(localize(other_day(), output, {"--duration", "8", "--threads", threads}), 0);
    return content_of(output / "trajectory/localized.tum") +
           content_of(output / "localization.csv");
  };
  const std::string by_one = with_threads("1");
  EXPECT_GT(by_one.size(), 5000U);
  EXPECT_EQ(by_one, with_threads("3"));
}

TEST_F(LocalizeBag, SaysThatADriveIsNotInTheMap) {
  const std::string elsewhere =
      bag("elsewhere", {"--lidar", "vlp16", "--seed", "77", "--duration", "10"});
  const fs::path output = root() / "nowhere";
  EXPECT_EQ(localize(elsewhere, output), 5);
  EXPECT_TRUE(has_said("the drive was never found in the map"));
  EXPECT_EQ(content_of(output / "trajectory/localized.tum"), "");
  EXPECT_TRUE(test::holds(content_of(output / "localization.csv"), ",searching,"));
}

TEST_F(LocalizeBag, TakesAnInitialPoseAndIsNotMisledByAWrongOne) {
  const auto truth = read_trajectory((other_day(), root() / "other_day.tum"));
  const Pose begin = T_truth_map().inverse() * truth.poses.front().pose;
  const auto pose_words = [](const Pose& pose, double shift) {
    return Words{"--duration",
                 "8",
                 "--initial-pose",
                 std::to_string(pose.translation.x() + shift),
                 std::to_string(pose.translation.y()),
                 std::to_string(pose.translation.z()),
                 "0",
                 "0",
                 std::to_string(yaw_of(pose.rotation) * kDegPerRad)};
  };
  for (const double shift : {2.0, 60.0}) {
    const fs::path output = root() / ("claimed_" + std::to_string(shift));
    EXPECT_EQ(localize(other_day(), output, pose_words(begin, shift)), 0);
    EXPECT_LT(errors_of("other_day", output).translation_m.max, 0.5) << shift;
  }
}

TEST_F(LocalizeBag, LeavesAFolderAloneThatIsNotEmpty) {
  std::ofstream(folder_.path() / "diary.txt") << "mine";
  EXPECT_EQ(localize(other_day(), folder_.path()), 1);
  EXPECT_TRUE(has_said("exists and is no empty folder"));
}

/// It said that no scan could be used, and ended as if the drive were at fault.
TEST_F(LocalizeBag, EndsAsStoppedByCtrlCWhileItReadsTheMap) {
  const Words words = {other_day(), map(), "-o", root() / "stopped", "--duration", "4"};
  const fs::path log = folder_.path() / "log";
  std::ofstream(log) << "";
  test::Program program("localize_bag", words, log);
  while (!test::holds(content_of(log), "\n") && !program.ends_within(0.001)) {  // it reads the map
  }
  program.kill(SIGINT);
  EXPECT_EQ(program.wait(), 3) << content_of(log);
  EXPECT_TRUE(test::holds(content_of(log), "stopped "));
}

TEST_F(LocalizeBag, WritesFiguresAsJson) {
  const fs::path figures = root() / "figures.json";
  EXPECT_EQ(
      localize(other_day(), root() / "timed", {"--duration", "4", "--figures", figures.string()}),
      0);
  EXPECT_TRUE(test::holds(content_of(figures), "\"found_after\""));
}

}  // namespace
}  // namespace lidar_mapping::tools
