// SPDX-License-Identifier: BSD-3-Clause
// What the headers of a topic tell, and the reports on them.

#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "checks/input_checks.hpp"
#include "checks/sensor_record.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;

TopicStatistics topic_of(const std::vector<double>& seconds, const std::string& frame = "imu") {
  TopicStatistics topic;
  for (const double s : seconds) topic.add(at(s), frame);
  return topic;
}

/// Knows the frame "imu" alone.
std::optional<Pose> lookup(const std::string& frame) {
  if (frame != "imu") return std::nullopt;
  return Pose::Identity();
}

/// The problems, a line each.
std::string problems_of(const InputReport& report) {
  std::string text;
  for (const CheckDiagnostic& diagnostic : report.diagnostics) {
    text += std::string(to_string(diagnostic.severity)) + " " + sentence(diagnostic) + "\n";
  }
  return text;
}

TEST(TopicStatistics, MeasureRateAndLongestGap) {
  const TopicStatistics topic = topic_of({0.0, 0.1, 0.2, 0.7, 0.8, 1.0});
  EXPECT_EQ(topic.count, 6U);
  EXPECT_EQ(topic.first, at(0.0));
  EXPECT_EQ(topic.newest, at(1.0));
  EXPECT_NEAR(topic.rate(), 5.0, 1e-9);
  EXPECT_EQ(topic.longest_gap, at(0.7) - at(0.2));
  EXPECT_EQ(topic.gap_begin, at(0.2));
  EXPECT_EQ(topic.backward, 0U);
}

TEST(TopicStatistics, CountStampsThatDoNotIncrease) {
  const TopicStatistics topic = topic_of({0.0, 0.5, 0.4, 0.5, 0.45, 0.6});
  EXPECT_EQ(topic.backward, 3U) << "each beside the newest of all, not beside the one before";
  EXPECT_EQ(topic.newest, at(0.6));
  EXPECT_EQ(topic.longest_gap, at(0.5) - at(0.0));
}

TEST(TopicStatistics, HaveNoRateOfOneMessage) {
  EXPECT_EQ(topic_of({}).rate(), 0.0);
  EXPECT_EQ(topic_of({3.0}).rate(), 0.0);
  EXPECT_EQ(topic_of({3.0, 3.0}).rate(), 0.0);
}

TEST(SensorRecord, KeepsTheFirstSamplesUpToItsLimit) {
  SensorRecord<int> record;
  const int limit = static_cast<int>(SensorRecord<int>::kMaxSamples);
  for (int i = 0; i < limit + 10; ++i) record.add_sample(i);
  ASSERT_EQ(record.samples.size(), SensorRecord<int>::kMaxSamples);
  EXPECT_EQ(record.samples.back(), limit - 1);
}

TEST(WithoutLeadingSlash, KeepsAllOtherSlashes) {
  EXPECT_EQ(without_leading_slash("/a/b"), "a/b");
  EXPECT_EQ(without_leading_slash("a/b"), "a/b");
  EXPECT_EQ(without_leading_slash(""), "");
  EXPECT_EQ(without_leading_slash("//a"), "/a");
}

TEST(CheckHeaders, SaysThatNothingCame) {
  const InputReport report = check_headers("imu", {}, lookup);
  EXPECT_EQ(report.input, "imu");
  EXPECT_EQ(report.found, "nothing came");
  EXPECT_EQ(problems_of(report), "");
}

TEST(CheckHeaders, FindsNoProblemInGoodOnes) {
  const InputReport report = check_headers("imu", topic_of({0.0, 0.1, 0.2}), lookup);
  EXPECT_EQ(report.found, "10.0 Hz, frame imu");
  EXPECT_EQ(problems_of(report), "");
}

TEST(CheckHeaders, SaysWhatAMissingTransformMeans) {
  const TopicStatistics topic = topic_of({0.0, 0.1}, "gps");
  const std::string of_gnss = problems_of(check_headers("gnss", topic, lookup));
  EXPECT_EQ(of_gnss.find("WARNING no transform from 'gps'"), 0U) << of_gnss;
  EXPECT_NE(of_gnss.find("without it the sensor is not used"), std::string::npos) << of_gnss;
  const std::string of_points = problems_of(check_headers("points", topic, lookup));
  EXPECT_NE(of_points.find("uses the frame of the scans"), std::string::npos) << of_points;
}

TEST(CheckHeaders, LooksUpFramesWithoutTheirLeadingSlash) {
  const InputReport report = check_headers("imu", topic_of({0.0, 0.1}, "/imu"), lookup);
  EXPECT_EQ(report.found, "10.0 Hz, frame /imu");
  ASSERT_EQ(report.diagnostics.size(), 1U) << problems_of(report);
  EXPECT_EQ(report.diagnostics[0].text, "frame '/imu' has a leading slash, which tf2 refuses");
}

TEST(CheckHeaders, NamesNoFrameThatIsNotThere) {
  const InputReport report = check_headers("imu", topic_of({0.0, 0.1}, ""), lookup);
  EXPECT_EQ(report.found, "10.0 Hz, frame (none)");
  ASSERT_EQ(report.diagnostics.size(), 1U) << problems_of(report);
  EXPECT_EQ(report.diagnostics[0].text, "the messages name no frame");
}

TEST(CheckHeaders, DistinguishesAClockThatWasSetBackFromTwoPublishers) {
  const std::string set_back = problems_of(
      check_headers("imu", topic_of({0.0, 0.1, 0.2, 0.3, 0.4, -0.1, 0.0, 0.1, 0.2}), lookup));
  EXPECT_EQ(set_back.find("FAULT the clock of the stamps was set back by 0.5 s: the 4 messages"),
            0U)
      << set_back;
  const std::string two = problems_of(
      check_headers("imu", topic_of({0.0, 0.5, 0.1, 0.6, 0.2, 0.7, 0.3, 0.8, 0.4}), lookup));
  EXPECT_EQ(two.find("FAULT 4 of 9 stamps do not increase: two publishers"), 0U) << two;
}

TEST(CheckHeaders, ReportsMessagesThatCameTwice) {
  const std::string twice =
      problems_of(check_headers("imu", topic_of({0.0, 0.0, 0.1, 0.1, 0.2}), lookup));
  EXPECT_EQ(twice.find("FAULT 2 of 5 messages have the stamp of the one before: they are left out"),
            0U)
      << twice;
}

TEST(CheckHeaders, NamesSeveralFramesOnOneTopic) {
  TopicStatistics topic = topic_of({0.0, 0.1});
  topic.add(at(0.2), "rear");
  const InputReport report = check_headers("imu", topic, lookup);
  EXPECT_EQ(report.found, "10.0 Hz, frame imu");
  ASSERT_EQ(report.diagnostics.size(), 1U) << problems_of(report);
  EXPECT_EQ(report.diagnostics[0].text, "the messages name several frames, 'imu' and 'rear'");
}

TEST(CheckHeaders, FindsATransformThatIsLongerThanAVehicle) {
  const auto in_millimetres = [](const std::string&) -> std::optional<Pose> {
    return Pose{Eigen::Quaterniond::Identity(), {760.0, 0.0, 1730.0}};
  };
  const InputReport report = check_headers("imu", topic_of({0.0, 0.1}), in_millimetres);
  ASSERT_EQ(report.diagnostics.size(), 1U) << problems_of(report);
  EXPECT_EQ(report.diagnostics[0].text, "the transform puts 'imu' 1890 m from the vehicle's frame");
}

TEST(CheckHeaders, TakesStampsOfZeroAndUnorderedOnesForFaults) {
  TopicStatistics zero;
  for (int i = 0; i < 3; ++i) zero.add(0, "imu");
  const std::string of_zero = problems_of(check_headers("imu", zero, lookup));
  EXPECT_EQ(of_zero.find("FAULT the stamps are 0: "), 0U) << of_zero;
  EXPECT_EQ(of_zero.find("do not increase"), std::string::npos) << of_zero;
  const std::string unordered =
      problems_of(check_headers("imu", topic_of({0.0, 0.2, 0.1, 0.3}), lookup));
  EXPECT_EQ(unordered.find("FAULT 1 of 4 stamps do not increase: "), 0U) << unordered;
}

/// What is said about stamps that are late by `seconds`, known to `sigma`.
std::string offset_problem(double seconds, double sigma, double configured = 0.0) {
  InputReport report;
  check_offset(TimeOffset{seconds, sigma}, "imu_time_offset", configured, report);
  return problems_of(report);
}

TEST(CheckOffset, SaysWhatToSet) {
  EXPECT_EQ(offset_problem(0.05, 0.001),
            "FAULT its stamps are 50 ms later than those of the velocity for the same motion: set "
            "imu_time_offset to -0.050\n");
  EXPECT_EQ(offset_problem(-0.03, 0.001),
            "FAULT its stamps are 30 ms earlier than those of the velocity for the same motion: "
            "set imu_time_offset to 0.030\n");
}

TEST(CheckOffset, CountsFromTheValueThatIsConfigured) {
  const std::string problem = offset_problem(0.05, 0.001, 0.03);
  EXPECT_NE(problem.find("set imu_time_offset to -0.020\n"), std::string::npos) << problem;
}

TEST(CheckOffset, KeepsSilentAboutSmallAndUncertainOnes) {
  EXPECT_EQ(offset_problem(0.019, 0.001), "");
  EXPECT_EQ(offset_problem(-0.019, 0.001), "");
  EXPECT_EQ(offset_problem(0.05, 0.013), "") << "less than four standard deviations";
  EXPECT_NE(offset_problem(0.05, 0.012), "");
  EXPECT_EQ(offset_problem(0.5, 0.021), "") << "not known well enough to be corrected";
  InputReport report;
  check_offset(std::nullopt, "imu_time_offset", 0.0, report);
  EXPECT_TRUE(report.diagnostics.empty());
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
