// SPDX-License-Identifier: BSD-3-Clause
// Times of the points that are missing or wrong are found out and corrected.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "evaluated_drive.hpp"
#include "near.hpp"
#include "recorded_scans.hpp"
#include "scan/sweep_times.hpp"
#include "test_data.hpp"
#include "tracking/sweep_times_validator.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kDuration = 0.1;  // s

SweepTimesRule rule(SweepTimes source) { return {source, kDuration, std::nullopt}; }

/// A point at this part of a counterclockwise round that begins at 30 degrees.
Point point_at(double rounds, double elevation = 0.0) {
  const double azimuth = 2.0 * kPi * rounds + kPi / 6.0;
  return {static_cast<float>(10.0 * std::cos(azimuth)),
          static_cast<float>(10.0 * std::sin(azimuth)), static_cast<float>(10.0 * elevation), 0.0F};
}

TEST(TimesByAzimuth, GrowWithTheAngleSinceTheFirstFiring) {
  PointCloud cloud;
  // The two lasers of a firing are 3 degrees apart.
  constexpr double kApart = 3.0 / 360.0;
  for (int firing = 0; firing < 360; ++firing) {
    cloud.points.push_back(point_at(firing / 360.0));
    cloud.points.push_back(point_at(firing / 360.0 - kApart, 0.1));
  }
  const std::vector<float> times = times_by_azimuth(cloud, kDuration);
  for (int firing = 0; firing < 360; ++firing) {
    EXPECT_NEAR(times[2 * firing], kDuration * firing / 360.0, 1e-6);
    EXPECT_NEAR(times[2 * firing + 1], kDuration * (firing / 360.0 - kApart), 1e-6);
  }
}

TEST(TimesByAzimuth, FollowTheDirectionOfRotationInEachRing) {
  PointCloud cloud;
  for (int ring = 0; ring < 4; ++ring) {
    for (int column = 0; column < 100; ++column)
      cloud.points.push_back(point_at(-column / 100.0, 0.1 * ring));
  }
  const std::vector<float> times = times_by_azimuth(cloud, kDuration);
  for (int i = 0; i < 400; ++i) EXPECT_NEAR(times[i], kDuration * (i % 100) / 100.0, 1e-6) << i;
}

TEST(TimesByAzimuth, AreOnTheOrderOfPointsWithoutCoordinates) {
  PointCloud cloud;
  for (int i = 0; i < 4; ++i) cloud.points.push_back(point_at(i / 4.0));
  cloud.points[2].x = std::nanf("");
  EXPECT_NEAR(times_by_azimuth(cloud, kDuration)[2], 0.5 * kDuration, 1e-6);
}

TEST(TimesByAzimuth, FollowAKnownRotationWhateverTheOrderOfThePoints) {
  PointCloud cloud;
  for (const double degrees : {0.0, 90.0, 179.0, -179.0, -90.0}) {
    const double azimuth = degrees * kRadPerDeg;
    cloud.points.push_back({static_cast<float>(5.0 * std::cos(azimuth)),
                            static_cast<float>(5.0 * std::sin(azimuth)), 0.0F, 0.0F});
  }
  cloud.points.push_back({std::nanf(""), 0.0F, 0.0F, 0.0F});
  const auto expect = [&](const SensorRotation& rotation, const std::vector<double>& rounds) {
    const std::vector<float> times = times_by_azimuth(cloud, kDuration, rotation);
    for (std::size_t i = 0; i < rounds.size(); ++i)
      EXPECT_NEAR(times[i], kDuration * rounds[i], 1e-6) << i;
  };
  expect({true, kPi}, {0.5, 0.25, 1.0 / 360.0, 359.0 / 360.0, 0.75, 0.0});
  expect({false, kPi}, {0.5, 0.75, 359.0 / 360.0, 1.0 / 360.0, 0.25, 0.0});
  expect({true, 0.0}, {0.0, 0.75, 181.0 / 360.0, 179.0 / 360.0, 0.25, 0.0});
}

TEST(SweepTimes, AreTakenFromTheirSource) {
  PointCloud cloud;
  for (int i = 0; i < 4; ++i) cloud.points.push_back(point_at(i / 4.0));
  EXPECT_TRUE(sweep_times(cloud, rule(SweepTimes::kAsGiven)).empty());
  EXPECT_NEAR(sweep_times(cloud, rule(SweepTimes::kByPosition))[3], 0.075, 1e-6);
  EXPECT_NEAR(sweep_times(cloud, rule(SweepTimes::kByAzimuth))[3], 0.075, 1e-6);
  const SweepTimesRule known{SweepTimes::kByAzimuth, kDuration, SensorRotation{false, kPi / 6.0}};
  EXPECT_NEAR(sweep_times(cloud, known)[3], 0.025, 1e-6) << "the stamp is in the middle";
  cloud.times = {0.0F, 0.1F, 0.2F, 0.3F};
  EXPECT_EQ(sweep_times(cloud, rule(SweepTimes::kAsGiven)), cloud.times);
  EXPECT_EQ(sweep_times(cloud, rule(SweepTimes::kNegated))[2], -0.2F);
}

TEST(SweepTimes, HaveAMessageUnlessTheyAreAsGiven) {
  EXPECT_EQ(sweep_times_message(rule(SweepTimes::kAsGiven)), "");
  EXPECT_NE(sweep_times_message(rule(SweepTimes::kNegated)).find("negates them"),
            std::string::npos);
  EXPECT_NE(sweep_times_message(rule(SweepTimes::kByAzimuth)).find("azimuth"), std::string::npos);
  const std::string known =
      sweep_times_message({SweepTimes::kByAzimuth, 0.104, SensorRotation{true, kPi}});
  EXPECT_NE(known.find("scan_stamp: MIDDLE, scan_direction: CLOCKWISE, scan_start_azimuth_deg: "
                       "180, scan_period: 0.104"),
            std::string::npos)
      << known;
  EXPECT_NE(sweep_times_message(rule(SweepTimes::kByPosition)).find("order of the points"),
            std::string::npos);
}

// A sensor may stand for days before the times of its points can be checked.
TEST(RecentMedian, ForgetsWhatIsLongAgo) {
  RecentMedian median;
  EXPECT_EQ(median.median(), 0.0);
  for (int i = 0; i < 1000; ++i) median.add(0.1);
  for (int i = 0; i < 20; ++i) median.add(0.3);
  EXPECT_EQ(median.median(), 0.1);
  for (int i = 0; i < 20; ++i) median.add(0.3);
  EXPECT_EQ(median.median(), 0.3);
  median.clear();
  median.add(0.2);
  EXPECT_EQ(median.median(), 0.2);
}

TEST(RunningMean, HasTheStandardDeviationOfTheMean) {
  RunningMean mean;
  EXPECT_TRUE(std::isinf(mean.sigma()));
  for (const double value : {1.0, 2.0, 3.0, 4.0}) mean.add(value);
  EXPECT_EQ(mean.count(), 4);
  EXPECT_DOUBLE_EQ(mean.mean(), 2.5);
  EXPECT_NEAR(mean.sigma(), std::sqrt(5.0 / 3.0 / 4.0), 1e-12);
}

struct Case {
  const char* drive;
  const char* lidar;
  const char* fault;  ///< of the scans; empty for none
  bool undistorted;   ///< the motion within the sweep is removed, and there are no times
  std::size_t first;  ///< scan
  SweepTimes expected;
  std::uint64_t seed = 405;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.drive << ' ' << c.lidar << ' ' << c.fault;
}

simulation::Drive drive_of(const Case& c) {
  const double duration = 0.1 * static_cast<double>(c.first) + 6.0;
  simulation::DriveOptions options = drive_options(c.drive, duration, c.seed, c.lidar);
  options.undistorted = c.undistorted;
  return faulty_drive(options, c.fault);
}

class PointTimes : public testing::TestWithParam<Case> {};

// Steps of scans with wrong times are off by up to the motion within a sweep. After the change
// nothing of that is left, and the change itself is no step.
TEST_P(PointTimes, AreFoundOut) {
  const simulation::Drive drive = drive_of(GetParam());
  EvaluatedDrive ride(drive);
  bool was_found = false;
  for (std::size_t i = GetParam().first; i < drive.scan_count(); ++i) {
    const FrontEndResult& result = ride.process(i);
    const Pose error = ride.step_error();
    if (was_found) {
      EXPECT_TRUE(test::near(error.translation, Eigen::Vector3d::Zero(), 0.05)) << i;
      EXPECT_LT(rotation_angle(error.rotation), 0.015) << i;
    }
    ride.end_step();
    was_found = result.status.sweep_times.source == GetParam().expected;
    EXPECT_TRUE(was_found || result.status.sweep_times.source == SweepTimes::kAsGiven) << i;
  }
  EXPECT_TRUE(was_found);
}

INSTANTIATE_TEST_SUITE_P(
    Drives, PointTimes,
    testing::Values(Case{"town", "vlp16", "", false, 90, SweepTimes::kAsGiven},
                    Case{"town", "vlp16", "", true, 90, SweepTimes::kAsGiven},
                    Case{"town", "vlp16", "times=negated", false, 90, SweepTimes::kNegated},
                    Case{"town", "vlp16", "times=none", false, 90, SweepTimes::kByAzimuth},
                    Case{"handheld", "mid360", "", false, 10, SweepTimes::kAsGiven},
                    // Negated times fit better than the given ones do in an older map.
                    Case{"stairs", "vlp16", "", false, 0, SweepTimes::kAsGiven, 83},
                    Case{"handheld", "mid360", "times=negated", false, 10, SweepTimes::kNegated},
                    Case{"handheld", "mid360", "times=none", false, 10, SweepTimes::kByPosition}));

// Filters leave the points in another order than that in which they were measured. The simulated
// sensor turns clockwise and begins behind.
TEST(PointTimesOfScansInAnyOrder, AreFoundOutWithTheRotationOfTheSensor) {
  const simulation::Drive drive =
      drive_of({"town", "vlp16", "times=none", false, 90, SweepTimes::kByAzimuth});
  EvaluatedDrive ride(drive);
  SweepTimesRule found;
  for (std::size_t i = 90; i < drive.scan_count(); ++i) {
    Scan scan = lidar_scan(drive, i);
    std::stable_sort(scan.cloud.points.begin(), scan.cloud.points.end(),
                     [](const Point& a, const Point& b) { return a.x < b.x; });
    found = ride.process(scan).status.sweep_times;
  }
  ASSERT_EQ(found.source, SweepTimes::kByAzimuth);
  ASSERT_TRUE(found.rotation);
  EXPECT_TRUE(found.rotation->clockwise);
  EXPECT_NEAR(found.rotation->start_azimuth, kPi, 1e-9);
  EXPECT_NEAR(found.duration, 0.1, 1e-3);
}

// KITTI's files are stored ring by ring, each from ahead on and against the rotation of the sensor.
// Two of three scans are missing.
TEST(PointTimesOfARecording, AreFoundOut) {
  REQUIRE_RECORDED(folder, "kitti00_scans");
  const std::vector<Stamp> stamps = test::recorded_stamps(folder);
  FrontEnd front_end{FrontEndConfig{}};
  SweepTimesRule found;
  for (std::size_t i = 0; i < 80; ++i) {
    const Scan scan = {from_seconds(1.0) + stamps.at(i), test::recorded_scan(folder, i)};
    found = front_end.process(scan).status.sweep_times;
  }
  ASSERT_EQ(found.source, SweepTimes::kByAzimuth);
  ASSERT_TRUE(found.rotation);
  EXPECT_TRUE(found.rotation->clockwise);
  EXPECT_NEAR(found.rotation->start_azimuth, kPi, 1e-9);
  EXPECT_NEAR(found.duration, 0.1, 1e-3);
}

TEST(PointTimesCheck, CanBeSwitchedOff) {
  const simulation::Drive drive =
      drive_of({"town", "vlp16", "times=negated", false, 90, SweepTimes::kNegated});
  FrontEndConfig config;
  config.check_point_times = false;
  FrontEnd front_end(config);
  for (std::size_t i = 90; i < drive.scan_count(); ++i) {
    EXPECT_EQ(front_end.process(lidar_scan(drive, i)).status.sweep_times.source,
              SweepTimes::kAsGiven);
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
