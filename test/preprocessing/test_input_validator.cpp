// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/preprocessing/input_validator.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

/// The messages of a simulated drive, to be corrupted before the validator checks them.
struct Messages {
  std::vector<CloudSummary> clouds;
  std::vector<ImuSample> imu;
  std::vector<VelocitySample> velocity;
  std::vector<GnssFix> gnss;
  std::string gnss_frame = "gnss_link";
  std::string imu_frame = "imu_link";
  simulation::SensorMounting mounting;

  explicit Messages(const simulation::DriveOptions& options = {}) {
    const simulation::Drive drive(options);
    imu = drive.imu();
    velocity = drive.velocity();
    gnss = drive.gnss();
    mounting = drive.mounting();
    for (std::size_t i = 0; i < drive.scan_count(); ++i) {
      CloudSummary cloud;
      cloud.stamp = drive.scan_stamp(i);
      cloud.frame_id = "velo_link";
      cloud.points = 100000;
      cloud.fields = "x y z intensity time";
      cloud.time_field = "time";
      cloud.time_unit = "s";
      cloud.last_time = 0.0999;
      clouds.push_back(cloud);
    }
  }
};

std::string all_faults(const Messages& messages, const PreprocessingConfig& config = {}) {
  InputValidator validator(config);
  for (const CloudSummary& cloud : messages.clouds) validator.add_scan(cloud);
  for (const ImuSample& sample : messages.imu) validator.add_imu(sample, messages.imu_frame);
  for (const VelocitySample& sample : messages.velocity) validator.add_velocity(sample, "imu_link");
  for (const GnssFix& fix : messages.gnss) validator.add_gnss(fix, messages.gnss_frame);
  const auto lookup = [&](const std::string& frame) -> std::optional<Pose> {
    if (frame == "velo_link") return messages.mounting.T_base_lidar;
    if (frame == "imu_link") return messages.mounting.T_base_imu;
    if (frame == "gnss_link") {
      return Pose{Eigen::Quaterniond::Identity(), messages.mounting.p_base_antenna};
    }
    return std::nullopt;
  };
  std::string faults;
  for (const InputReport& report : validator.report(lookup)) {
    EXPECT_FALSE(report.found.empty());
    for (const CheckDiagnostic& diagnostic : report.diagnostics) {
      EXPECT_FALSE(diagnostic.remedy.empty()) << diagnostic.text;
      faults += report.input + ": " + sentence(diagnostic) + "\n";
    }
  }
  return faults;
}

/// The drive is simulated once; every test spoils a copy.
const Messages& clean() {
  static const Messages messages;
  return messages;
}

/// Exactly one fault, and it speaks of `word`.
void expect_fault(const Messages& messages, const std::string& word) {
  const std::string faults = all_faults(messages);
  EXPECT_NE(faults.find(word), std::string::npos) << faults;
  EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 1) << faults;
}

TEST(InputValidator, FindsNoProblemInACleanDrive) { EXPECT_EQ(all_faults(clean()), ""); }

TEST(InputValidator, FindsAccelerationsInG) {
  Messages messages = clean();
  for (ImuSample& sample : messages.imu) sample.linear_acceleration /= 9.81;
  expect_fault(messages, "in g");
}

TEST(InputValidator, FindsGravityOfTheWrongSign) {
  Messages messages = clean();
  for (ImuSample& sample : messages.imu) sample.linear_acceleration *= -1.0;
  expect_fault(messages, "wrong sign");
}

TEST(InputValidator, FindsRatesInDegrees) {
  Messages messages = clean();
  for (ImuSample& sample : messages.imu) sample.angular_velocity *= 180.0 / M_PI;
  expect_fault(messages, "degrees");
  messages.velocity.clear();
  expect_fault(messages, "degrees");
}

// The stamps of rates in degrees/s are compared, too.
TEST(InputValidator, ReadsRatesInTheUnitOfTheConfiguration) {
  Messages messages = clean();
  for (ImuSample& sample : messages.imu) sample.angular_velocity *= 180.0 / M_PI;
  PreprocessingConfig config;
  config.imu_angular_unit = AngularUnit::kDegrees;
  EXPECT_EQ(all_faults(messages, config), "");
  for (ImuSample& sample : messages.imu) sample.stamp += from_seconds(0.05);
  const std::string faults = all_faults(messages, config);
  EXPECT_NE(faults.find("set imu_time_offset"), std::string::npos) << faults;
}

TEST(InputValidator, FindsMissingTransformsAndSlashes) {
  Messages messages = clean();
  messages.gnss_frame = "gps";
  expect_fault(messages, "no transform from 'gps'");
  messages.gnss_frame = "/gnss_link";
  expect_fault(messages, "leading slash");
  messages.gnss_frame = "";
  expect_fault(messages, "name no frame");
}

TEST(InputValidator, FindsMissingAndWrongPointTimes) {
  Messages messages = clean();
  for (CloudSummary& cloud : messages.clouds) cloud.time_field.clear();
  expect_fault(messages, "no times");
  messages = clean();
  for (CloudSummary& cloud : messages.clouds) cloud.last_time = 0.0001;
  expect_fault(messages, "span");
  messages.clouds.clear();
  expect_fault(messages, "nothing came");
}

/// Five or twenty turns a second: the span is what passes from scan to scan, whatever scan_period.
TEST(InputValidator, AcceptsTheTimesOfSlowAndFastSensors) {
  const Stamp start = clean().clouds.front().stamp;
  for (const double period : {0.2, 0.05}) {
    Messages messages = clean();
    for (CloudSummary& cloud : messages.clouds) {
      cloud.stamp = start + from_seconds(period / 0.1 * to_seconds(cloud.stamp - start));
      cloud.last_time = 0.999 * period;
    }
    EXPECT_EQ(all_faults(messages), "") << period;
    PreprocessingConfig at_end;
    at_end.scan_stamp = ScanStamp::kEnd;
    EXPECT_NE(all_faults(messages, at_end).find("set scan_period"), std::string::npos) << period;
  }
}

TEST(InputValidator, FindsTheUnitAndTheSignOfAVelocityByTheImu) {
  for (const auto& [scale, words] :
       {std::pair{3.6, "it is in km/h"}, std::pair{-1.0, "its sign is wrong"},
        std::pair{0.0, "it never changes"}}) {
    Messages messages = clean();
    messages.gnss.clear();
    for (VelocitySample& sample : messages.velocity) sample.linear *= scale;
    expect_fault(messages, words);
  }
}

TEST(InputValidator, AcceptsTheTimesOfAPartOfTheTurn) {
  Messages messages = clean();
  for (CloudSummary& cloud : messages.clouds) {
    cloud.first_time = 0.03;
    cloud.last_time = 0.06;
  }
  EXPECT_EQ(all_faults(messages), "");
}

TEST(InputValidator, FindsPartsOfTurns) {
  const Stamp start = clean().clouds.front().stamp;
  Messages messages = clean();
  for (CloudSummary& cloud : messages.clouds) {
    cloud.stamp = start + (cloud.stamp - start) / 10;
    cloud.last_time = 0.0099;
  }
  expect_fault(messages, "100 clouds a second of 100000 points are parts of turns");
}

TEST(InputValidator, FindsTimesThatCountFromTheStampInSomeScansOnly) {
  Messages messages = clean();
  for (std::size_t i = 0; i < messages.clouds.size(); ++i) {
    messages.clouds[i].foreign_clock = i % 10 > 2;
  }
  expect_fault(messages, "as a clock that begins anew every second");
}

TEST(InputValidator, FindsLostScansAndDecreasingStamps) {
  Messages messages = clean();
  messages.clouds.erase(messages.clouds.begin() + 100, messages.clouds.begin() + 120);
  expect_fault(messages, "without a scan");
  messages = clean();
  std::swap(messages.imu[100], messages.imu[101]);
  expect_fault(messages, "do not increase");
}

TEST(InputValidator, FindsSwappedLatitudesAndLongitudes) {
  Messages messages = clean();
  for (GnssFix& fix : messages.gnss) std::swap(fix.latitude_deg, fix.longitude_deg);
  expect_fault(messages, "latitude and longitude are swapped");
}

TEST(InputValidator, FindsOutagesAndJumps) {
  simulation::DriveOptions outage;
  outage.gnss_outages = {{50.0, 110.0}};
  const std::string faults = all_faults(Messages(outage));
  EXPECT_NE(faults.find("no usable fix for 60"), std::string::npos) << faults;
  for (const double metres : {5.0, 50.0}) {
    simulation::DriveOptions jump;
    jump.gnss_jumps = {{50.0, metres}};
    expect_fault(Messages(jump), "2 jumps");
  }
}

TEST(InputValidator, FindsCovariancesThatAreTooSmall) {
  Messages messages = clean();
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0.0, 0.45);  // m
  for (GnssFix& fix : messages.gnss) {
    fix.latitude_deg += noise(engine) / 111000.0;
    fix.longitude_deg += noise(engine) / (111000.0 * std::cos(fix.latitude_deg * kRadPerDeg));
  }
  const std::string faults = all_faults(messages);
  EXPECT_NE(faults.find("scatter"), std::string::npos) << faults;
  EXPECT_NE(faults.find("set gnss_sigma_floor_xy to 0.5 "), std::string::npos) << faults;
}

TEST(InputValidator, FindsCovariancesThatAreTooSmallBelowTheBound) {
  Messages messages = clean();
  for (GnssFix& fix : messages.gnss) *fix.covariance *= 0.01;
  const std::string faults = all_faults(messages);
  EXPECT_NE(faults.find("gnss_sigma_floor_xy (0.05 m) is used instead"), std::string::npos)
      << faults;
}

TEST(InputValidator, FindsTimeOffsets) {
  for (const double offset : {0.05, -0.05}) {
    Messages messages = clean();
    for (GnssFix& fix : messages.gnss) fix.stamp += from_seconds(offset);
    expect_fault(messages, offset > 0.0 ? "ms later" : "ms earlier");
    messages = clean();
    for (ImuSample& sample : messages.imu) sample.stamp += from_seconds(offset);
    expect_fault(messages, "imu_time_offset");
  }
}

/// The value that the faults recommend for a parameter; NaN if they do not.
double recommended(const std::string& faults, const std::string& parameter) {
  const std::string words = "set " + parameter + " to ";
  const std::size_t at = faults.find(words);
  return at == std::string::npos ? std::nan("") : std::stod(faults.substr(at + words.size()));
}

TEST(InputValidator, FindsNothingWhereTheTimeOffsetsOfTheConfigurationAreRight) {
  Messages messages = clean();
  for (ImuSample& sample : messages.imu) sample.stamp += from_seconds(0.05);
  for (VelocitySample& sample : messages.velocity) sample.stamp += from_seconds(-0.04);
  for (GnssFix& fix : messages.gnss) fix.stamp += from_seconds(0.06);
  PreprocessingConfig config;
  config.imu_time_offset = -0.05;
  config.velocity_time_offset = 0.04;
  config.gnss_time_offset = -0.06;
  EXPECT_EQ(all_faults(messages, config), "");
}

TEST(InputValidator, RecommendsTimeOffsetsThatReplaceThoseOfTheConfiguration) {
  Messages messages = clean();
  for (ImuSample& sample : messages.imu) sample.stamp += from_seconds(0.03);
  PreprocessingConfig of_imu;
  of_imu.imu_time_offset = -0.08;
  EXPECT_NEAR(recommended(all_faults(messages, of_imu), "imu_time_offset"), -0.03, 0.01);
  messages = clean();
  for (GnssFix& fix : messages.gnss) fix.stamp += from_seconds(0.03);
  PreprocessingConfig of_gnss;
  of_gnss.gnss_time_offset = -0.08;
  EXPECT_NEAR(recommended(all_faults(messages, of_gnss), "gnss_time_offset"), -0.03, 0.01);
}

TEST(InputValidator, FindsVelocitiesInTheAxesOfTheMap) {
  Messages messages = clean();
  for (VelocitySample& sample : messages.velocity) {
    sample.linear = exp_so3({0.0, 0.0, 1.2}) * sample.linear;
  }
  const std::string faults = all_faults(messages);
  EXPECT_NE(faults.find("points aside"), std::string::npos) << faults;
}

TEST(InputValidator, FindsStampsThatAreNotTheStartOfTheScan) {
  const auto with_delay = [](double delay) {
    Messages messages = clean();
    for (CloudSummary& cloud : messages.clouds) cloud.delay = delay;
    return messages;
  };
  expect_fault(with_delay(0.01), "set scan_stamp to END");
  expect_fault(with_delay(0.06), "set scan_stamp to MIDDLE");
  EXPECT_EQ(all_faults(with_delay(0.11)), "");
  EXPECT_EQ(all_faults(with_delay(0.0)), "");  // made, not recorded
  PreprocessingConfig config;
  config.scan_stamp = ScanStamp::kEnd;
  EXPECT_EQ(all_faults(with_delay(0.01), config), "");
}

TEST(InputValidator, FindsSpeedsInOtherUnits) {
  for (const auto& [scale, word] :
       {std::pair{3.6, "km/h"}, std::pair{2.237, "times those of the fixes"}}) {
    Messages messages = clean();
    for (VelocitySample& sample : messages.velocity) sample.linear *= scale;
    expect_fault(messages, word);
  }
}

TEST(InputValidator, FindsInvalidFixes) {
  Messages messages = clean();
  for (std::size_t i = 0; i < 100; ++i) {
    messages.gnss[5 * i].latitude_deg = messages.gnss[5 * i].longitude_deg = 0.0;
  }
  expect_fault(messages, "100 fixes refused: coordinates (0, 0)");
}

TEST(InputValidator, CountsRefusedFixesByTheKindOfTheirProblem) {
  Messages messages = clean();
  for (std::size_t i = 0; i < 10; ++i) {
    messages.gnss[20 * i].altitude_m = 20000.0 + static_cast<double>(i);
    messages.gnss[20 * i + 10].latitude_deg = 95.0;
  }
  const std::string faults = all_faults(messages);
  EXPECT_NE(faults.find("10 fixes refused: height 20000 m is implausible (from -2000 to 12000 m)"),
            std::string::npos)
      << faults;
  EXPECT_NE(faults.find("10 fixes refused: coordinates that are no degrees ("), std::string::npos)
      << faults;
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
