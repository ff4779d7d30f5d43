// SPDX-License-Identifier: BSD-3-Clause
// Clocks of sensors that are far apart, by the times of delivery.

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/input_validator.hpp"

#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;

constexpr double kDelayOfClouds = 0.11;  // s: a turn, and 10 ms of the network

/// What is said of the IMU of a vehicle that stands for 5 s, whose samples are delivered so many
/// seconds after their stamps.
std::string findings(const std::function<double(int)>& delay_of_sample,
                     double delay_of_clouds = kDelayOfClouds,
                     const PreprocessingConfig& config = {}) {
  InputValidator validator(config);
  for (int i = 0; i < 50; ++i) {
    CloudSummary cloud;
    cloud.stamp = at(0.1 * i);
    cloud.frame_id = "lidar";
    cloud.points = 1000;
    cloud.delay = delay_of_clouds;
    validator.add_scan(cloud);
    for (int k = 10 * i; k < 10 * (i + 1); ++k) {
      validator.add_imu(test::imu(at(0.01 * k)), "imu", delay_of_sample(k));
    }
  }
  const std::vector<InputReport> reports = validator.report(test::identity_lookup);
  std::string text;
  for (const CheckDiagnostic& diagnostic : reports[1].diagnostics) {
    text += sentence(diagnostic) + "\n";
  }
  return text;
}

std::string findings_of_steady(double delay, double delay_of_clouds = kDelayOfClouds,
                               const PreprocessingConfig& config = {}) {
  return findings([delay](int) { return delay; }, delay_of_clouds, config);
}

TEST(ClockCheck, FindsNothingInUsualDelays) {
  EXPECT_EQ(findings_of_steady(0.002), "");
  EXPECT_EQ(findings_of_steady(0.7), "") << "a slow driver";
}

TEST(ClockCheck, SaysWhichParameterCorrectsSomeSeconds) {
  const std::string late = findings_of_steady(3.11);
  EXPECT_NE(late.find("its stamps are 3.0 s behind those of the points"), std::string::npos)
      << late;
  EXPECT_NE(late.find("set imu_time_offset to 3.0 "), std::string::npos) << late;
  const std::string early = findings_of_steady(-1.89);
  EXPECT_NE(early.find("its stamps are 2.0 s ahead of"), std::string::npos) << early;
  EXPECT_NE(early.find("set imu_time_offset to -2.0 "), std::string::npos) << early;
}

TEST(ClockCheck, IsContentWithAnOffsetThatIsConfigured) {
  PreprocessingConfig config;
  config.imu_time_offset = 3.0;
  EXPECT_EQ(findings_of_steady(3.11, kDelayOfClouds, config), "");
  const std::string unnecessary = findings_of_steady(0.11, kDelayOfClouds, config);
  EXPECT_NE(unnecessary.find("set imu_time_offset to 0.0 "), std::string::npos) << unnecessary;
}

TEST(ClockCheck, NamesTheSensorWhoseClockNobodySet) {
  const double since_1970 = 1.3e9;  // s: the stamps count from when the sensor was switched on
  const std::string of_points = findings_of_steady(0.002, since_1970);
  EXPECT_NE(of_points.find("the LiDAR's driver must stamp"), std::string::npos) << of_points;
  const std::string of_imu = findings_of_steady(since_1970);
  EXPECT_NE(of_imu.find("its driver must stamp"), std::string::npos) << of_imu;
}

/// A bag that was written anew has other times than those of the deliveries.
TEST(ClockCheck, IgnoresTimesOfRecordingThatScatter) {
  EXPECT_EQ(findings([](int sample) { return 0.1 * sample; }), "");
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
