// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/tracking_summary.hpp"

namespace lidar_mapping::pipeline {
namespace {

/// Scans a tenth of a second and a metre apart along x.
class Drive {
 public:
  TrackingSummary summary;

  void add(std::optional<Doubt> doubt, double unobserved_stddev = 0.0,
           std::optional<double> probability = std::nullopt) {
    const Eigen::Vector3d position(static_cast<double>(scans_), 0.0, 0.0);
    summary.add({stamp(scans_++), doubt, position, unobserved_stddev, probability});
  }
  void add(int count, std::optional<Doubt> doubt) {
    for (int i = 0; i < count; ++i) add(doubt);
  }
  static Stamp stamp(int scan) { return from_seconds(50.0) + from_seconds(0.1) * scan; }
  const DoubtfulSection& section(std::size_t i) const { return summary.sections().at(i); }

 private:
  int scans_ = 0;
};

TEST(TrackingSummary, CountsScansAndPath) {
  Drive drive;
  drive.add(21, std::nullopt);
  EXPECT_EQ(drive.summary.scans(), 21U);
  EXPECT_EQ(drive.summary.path_length(), 20.0);
  EXPECT_TRUE(drive.summary.sections().empty());
}

TEST(TrackingSummary, CountsNoPathToTheBeginningOfADrive) {
  TrackingSummary summary;
  const auto add = [&](double seconds, double x, bool begins_drive) {
    summary.add({from_seconds(seconds), Doubt::kDegraded, {x, 0.0, 0.0}, 2.0, -1.0, begins_drive});
  };
  add(50.0, 0.0, false);
  add(50.1, 1.0, false);
  add(90.0, 700.0, true);
  add(90.1, 701.0, false);
  EXPECT_NEAR(summary.path_length(), 2.0, 1e-12);
  ASSERT_EQ(summary.sections().size(), 2U);
  EXPECT_NEAR(summary.sections()[1].path_length, 1.0, 1e-12);
  EXPECT_NEAR(summary.sections()[1].expected_error, 2.0, 1e-12) << "what came anew in this drive";
}

TEST(TrackingSummary, DescribesASection) {
  Drive drive;
  drive.add(10, std::nullopt);
  drive.add(5, Doubt::kLost);
  drive.add(3, std::nullopt);
  ASSERT_EQ(drive.summary.sections().size(), 1U);
  const DoubtfulSection& section = drive.section(0);
  EXPECT_EQ(section.doubt, Doubt::kLost);
  EXPECT_EQ(section.begin, Drive::stamp(10));
  EXPECT_EQ(section.end, Drive::stamp(14));
  EXPECT_EQ(section.scans, 5U);
  EXPECT_EQ(section.path_begin, 9.0) << "with the step that leads into it";
  EXPECT_EQ(section.path_length, 5.0);
  EXPECT_EQ(section.position, Eigen::Vector3d(10.0, 0.0, 0.0));
}

TEST(TrackingSummary, JoinsWhatIsASecondApart) {
  Drive drive;
  drive.add(Doubt::kDegraded);
  drive.add(9, std::nullopt);
  drive.add(Doubt::kDegraded);  // one second later
  EXPECT_EQ(drive.summary.sections().size(), 1U);
  EXPECT_EQ(drive.section(0).scans, 2U);
  drive.add(10, std::nullopt);
  drive.add(Doubt::kDegraded);
  EXPECT_EQ(drive.summary.sections().size(), 2U);
}

TEST(TrackingSummary, KeepsReasonsApart) {
  Drive drive;
  for (int i = 0; i < 3; ++i) {
    drive.add(Doubt::kDegenerate);
    drive.add(Doubt::kDoubtful);
  }
  ASSERT_EQ(drive.summary.sections().size(), 2U);
  EXPECT_EQ(drive.section(0).doubt, Doubt::kDegenerate);
  EXPECT_EQ(drive.section(0).end, Drive::stamp(4));
  EXPECT_EQ(drive.section(1).doubt, Doubt::kDoubtful);
  EXPECT_EQ(drive.section(1).scans, 3U);
}

/// Variances add up: from 0.3 m before the section to 0.5 m at its end is 0.4 m.
TEST(TrackingSummary, ExpectsTheErrorThatGrowsOverTheSection) {
  Drive drive;
  drive.add(std::nullopt, 0.3);
  drive.add(Doubt::kDegenerate, 0.4);
  drive.add(Doubt::kDegenerate, 0.5);
  EXPECT_NEAR(drive.section(0).expected_error, 0.4, 1e-12);
}

/// A front end that was started again counts from zero.
TEST(TrackingSummary, GoesOnAfterARestartOfTheFrontEnd) {
  Drive drive;
  drive.add(Doubt::kDegenerate, 0.3);
  drive.add(Doubt::kDegenerate, 0.1);
  drive.add(Doubt::kDegenerate, 0.4);
  EXPECT_NEAR(drive.section(0).expected_error, 0.5, 1e-12) << "0.3 m and 0.4 m";
}

TEST(TrackingSummary, RemembersTheLowestProbability) {
  Drive drive;
  drive.add(Doubt::kDoubtful);
  EXPECT_FALSE(drive.section(0).lowest_probability.has_value()) << "none is known";
  for (const double probability : {0.6, 0.2, 0.4}) {
    drive.add(Doubt::kDoubtful, 0.0, probability);
  }
  drive.add(Doubt::kDoubtful);
  EXPECT_EQ(drive.section(0).lowest_probability, 0.2);
}

TEST(Doubt, HasTheNameOfItsState) {
  for (const Doubt doubt :
       {Doubt::kDoubtful, Doubt::kDegraded, Doubt::kRepeated, Doubt::kDegenerate, Doubt::kLost}) {
    EXPECT_EQ(doubt_of_state(to_string(doubt)), doubt) << to_string(doubt);
  }
  EXPECT_EQ(doubt_of_state("tracking"), std::nullopt);
}

TEST(AllowedError, IsAFractionOfTheLengthAndAtLeastHalfAMetre) {
  EXPECT_EQ(allowed_error(0.0), 0.5);
  EXPECT_EQ(allowed_error(50.0), 0.5);
  EXPECT_DOUBLE_EQ(allowed_error(300.0), 3.0);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
