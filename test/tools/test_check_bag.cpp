// SPDX-License-Identifier: BSD-3-Clause

#include <gtest/gtest.h>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/ros/recording_check.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "holds.hpp"
#include "simulated_drive/drive_output.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

simulation::DriveOptions options_of(double duration) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  options.duration = duration;
  options.movers = false;
  return options;
}

/// Clouds of 16 s: enough of them move.
simulation::DriveOptions short_drive() { return options_of(16.0); }
/// For GNSS, whose faults take turns to be seen; without clouds.
simulation::DriveOptions long_drive() { return options_of(110.0); }

BagContent with(BagFault fault) {
  BagContent content;
  content.faults = {fault};
  return content;
}

BagContent without_clouds(BagContent content = {}) {
  content.lidar = false;
  return content;
}

/// "input: text: remedy" of every finding; of points only if the bag holds any.
std::vector<std::string> findings_in(const simulation::DriveOptions& options,
                                     const BagContent& content) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "drive.bag").string();
  write_bag(simulation::Drive(options), path, content, 1);
  const ros_border::BagSet bags({path});
  ros_border::RecordingCheck recording;
  recording.bags = &bags;
  recording.topics = ros_border::topics_in(bags);
  std::vector<std::string> diagnostics;
  for (const auto& report : ros_border::check(recording, {})) {
    if (report.input == "points" && !content.lidar) continue;
    for (const auto& diagnostic : report.diagnostics) {
      diagnostics.push_back(report.input + ": " + sentence(diagnostic));
    }
  }
  return diagnostics;
}

/// A finding that holds the words, and no other that is about something else.
void expect_only(const std::vector<std::string>& diagnostics, const std::string& words) {
  EXPECT_TRUE(test::holds(joined(diagnostics, "\n"), words));
  EXPECT_EQ(diagnostics.size(), 1U) << joined(diagnostics, "\n");
}

TEST(CheckBag, FindsNothingInCleanBags) {
  EXPECT_EQ(joined(findings_in(short_drive(), {}), "\n"), "");
  EXPECT_EQ(joined(findings_in(long_drive(), without_clouds()), "\n"), "");
}

TEST(CheckBag, FindsFaultsOfClouds) {
  expect_only(findings_in(short_drive(), with(BagFault::kNoPointTimes)),
              "points: the points have no times");
  expect_only(findings_in(short_drive(), with(BagFault::kLeadingSlash)), "leading slash");
  expect_only(findings_in(short_drive(), with(BagFault::kNoStamps)), "the stamps are 0");
  expect_only(findings_in(short_drive(), with(BagFault::kStampInTheMiddle)),
              "set scan_stamp to MIDDLE");
  simulation::DriveOptions undistorted = short_drive();
  undistorted.undistorted = true;
  expect_only(findings_in(undistorted, with(BagFault::kDeskewedTwice)), "set point_times to NONE");
}

TEST(CheckBag, FindsFaultsOfImuAndVelocity) {
  const auto spoilt = [](BagFault fault) {
    return findings_in(options_of(40.0), without_clouds(with(fault)));
  };
  expect_only(spoilt(BagFault::kImuInG), "set imu_acceleration_unit to G");
  expect_only(spoilt(BagFault::kGyroInDegrees), "set imu_angular_unit to DEG_PER_S");
  expect_only(spoilt(BagFault::kVelocityInKmh), "they are in km/h");
  const auto diagnostics = spoilt(BagFault::kNoImuTransform);  // the velocity has the same frame
  ASSERT_EQ(diagnostics.size(), 2U) << joined(diagnostics, "\n");
  EXPECT_NE(diagnostics[0].find("no transform from 'imu_link'"), std::string::npos);
}

TEST(CheckBag, FindsAntennasThatAreElsewhereAndLateStamps) {
  expect_only(findings_in(long_drive(), without_clouds(with(BagFault::kAntennaElsewhere))),
              "antenna at (-0.");
  expect_only(findings_in(long_drive(), without_clouds(with(BagFault::kGnssLate))),
              "set gnss_time_offset to -0.05");
}

TEST(CheckBag, FindsOutagesJumpsAndWrongCovariances) {
  simulation::DriveOptions options = long_drive();
  options.gnss_outages = {{40.0, 100.0}};
  const std::string outage = joined(findings_in(options, without_clouds()), "\n");
  EXPECT_TRUE(test::holds(outage, "no usable fix for 60"));
  for (const double metres : {5.0, 50.0}) {
    options = long_drive();
    options.gnss_jumps = {{50.0, metres}};
    expect_only(findings_in(options, without_clouds()), "2 jumps of up to");
  }
  options = long_drive();
  options.gnss_noise = 0.6;
  expect_only(findings_in(options, without_clouds(with(BagFault::kGnssTooConfident))),
              "fixes scatter by");
}

}  // namespace
}  // namespace lidar_mapping::tools
