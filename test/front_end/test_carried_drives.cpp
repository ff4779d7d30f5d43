// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/front_end/prior_of.hpp"

#include "campaign_imu.hpp"
#include "evaluated_drive.hpp"

namespace lidar_mapping::front_end {
namespace {

simulation::Drive carried_drive(const std::string& name, double duration,
                                const std::string& fault = "") {
  simulation::DriveOptions options = drive_options(name, duration, 3);
  options.imu = "consumer";
  return faulty_drive(options, fault);
}

struct Outcome {
  std::size_t lost = 0;
  std::size_t distrusted = 0;           ///< scans, by the front end
  std::size_t refused = 0;              ///< scans, by preprocessing
  double largest_turn = 0.0;            ///< rad, error of a step
  double start_error = 0.0;             ///< m, after the first second
  double error = 0.0;                   ///< m, since then
  double vertical_ride_distance = 0.0;  ///< m
  SweepTimes times = SweepTimes::kAsGiven;
};

/// Number of the scan that ends it. In a map of one scan of 16 beams the first step is off by up to
/// a tenth of a metre; the errors after it are counted separately.
constexpr std::size_t kFirstSecond = 10;

Outcome follow(const simulation::Drive& drive) {
  EvaluatedDrive ride(drive);
  campaign::ImuFeed scans(drive);
  Outcome outcome;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const preprocessing::SyncedScan synced = scans.next(i).value();
    const FrontEndResult& result = ride.process(
        synced.scan,
        prior_of(synced.imu, std::nullopt, synced.uneven_turning, synced.felt, synced.fingerprint));
    outcome.lost += result.status.state == TrackingState::kLost ? 1 : 0;
    outcome.distrusted += result.status.gyro_distrusted ? 1 : 0;
    outcome.refused += synced.imu && !synced.imu->has_angular_velocity ? 1 : 0;
    outcome.vertical_ride_distance = result.status.vertical_ride_distance;
    outcome.times = result.status.sweep_times.source;
    const double turn_error = rotation_angle(ride.step_error().rotation);
    if (i > 0) outcome.largest_turn = std::max(outcome.largest_turn, turn_error);
    ride.end_step();
    if (i == kFirstSecond) {
      outcome.start_error = ride.error();
      ride.restart_evaluation();
    }
  }
  outcome.error = ride.error();
  return outcome;
}

// Without a gyro, scans of a sensor with few beams turned by a degree or two, and the next ones
// back.
TEST(CarriedDrive, StepsRotateCorrectlyWithAGyro) {
  for (const char* name : {"legged", "spin", "handheld"}) {
    SCOPED_TRACE(name);
    const Outcome outcome = follow(carried_drive(name, 12.0));
    EXPECT_EQ(outcome.lost, 0U);
    EXPECT_EQ(outcome.distrusted, 0U);
    EXPECT_EQ(outcome.vertical_ride_distance, 0.0);
    EXPECT_LT(outcome.largest_turn, 1.0 * kRadPerDeg);
    EXPECT_LT(outcome.start_error, 0.12);
    EXPECT_LT(outcome.error, 0.05);
  }
}

TEST(CarriedDrive, WrongGyroIsDetected) {
  for (const char* fault : {"imu_frame", "imu_units=degrees"}) {
    SCOPED_TRACE(fault);
    const Outcome outcome = follow(carried_drive("running", 12.0, fault));
    EXPECT_GT(outcome.distrusted + outcome.refused, 20U);
  }
}

/// By the LiDAR alone, m.
double error_without_imu(const simulation::Drive& drive) {
  EvaluatedDrive ride(drive);
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    ride.process(i);
    if (i == kFirstSecond) ride.restart_evaluation();
  }
  return ride.error();
}

// A wrong gyro bends the scans, and a gyro at the limit of its range predicts wrong rotations. Used
// without a check, both lead metres away where the LiDAR alone is off by centimetres.
TEST(CarriedDrive, WrongGyroIsHarmless) {
  for (const char* fault : {"imu_units=degrees", "imu_frame", "imu_clip=4,1.5"}) {
    for (const char* name : {"legged", "handheld"}) {
      SCOPED_TRACE(std::string(fault) + ", " + name);
      const simulation::Drive drive = carried_drive(name, 12.0, fault);
      const Outcome outcome = follow(drive);
      EXPECT_EQ(outcome.lost, 0U);
      EXPECT_LT(outcome.error, error_without_imu(drive) + 0.05);
      EXPECT_EQ(outcome.times, SweepTimes::kAsGiven) << "it is not the times that are wrong";
    }
  }
}

// The samples of the gyro are missing for two seconds.
TEST(CarriedDrive, GyroMayFailForSeconds) {
  const Outcome outcome = follow(carried_drive("handheld", 12.0, "imu_gap=2,6"));
  EXPECT_EQ(outcome.lost, 0U);
  EXPECT_LT(outcome.start_error, 0.12);
  EXPECT_LT(outcome.error, 0.05);
}

}  // namespace
}  // namespace lidar_mapping::front_end
