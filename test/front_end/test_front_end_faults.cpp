// SPDX-License-Identifier: BSD-3-Clause
// Errors of earlier front ends, each with a drive that would show it.

#include <gtest/gtest.h>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/front_end/deskew.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/registration/registration.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "evaluated_drive.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

/// At speed in the town.
constexpr std::size_t kFirst = 90;
constexpr double kPeriod = 0.1;  // s

simulation::Drive drive_of(const std::string& name) { return make_drive(name, 20.0); }

PointCloud ground_of(const PointCloud& cloud) {
  PointCloud ground;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.points[i].z > 0.3F) continue;
    ground.points.push_back(cloud.points[i]);
    ground.times.push_back(cloud.times[i]);
  }
  return ground;
}

/// Distance (m) from where `from` and the true motion since then put it.
double error(const simulation::Drive& drive, std::size_t from, const Pose& T_odom_from,
             std::size_t to, const Pose& T_odom_to) {
  return (true_motion(drive, from, to).inverse() * T_odom_from.inverse() * T_odom_to)
      .translation.norm();
}

// Sweeps of another place are reported from the third one on and never become key frames, and the
// drive continues when the view returns.
TEST(FrontEndFaults, SweepsOfAnotherPlaceAreReportedAndNotInserted) {
  const simulation::Drive drive = drive_of("town");
  const simulation::Drive elsewhere = drive_of("car_park");
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult result;
  Pose T_odom_before;
  for (std::size_t i = kFirst; i < kFirst + 40; ++i) {
    const bool foreign = i >= kFirst + 25 && i < kFirst + 29;
    Scan scan = foreign ? elsewhere.base_scan(i) : drive.base_scan(i);
    scan.stamp = drive.scan_stamp(i);
    result = front_end.process(scan);
    if (i == kFirst + 24) T_odom_before = result.T_odom_base;
    if (!foreign) continue;
    EXPECT_FALSE(result.key_frame) << i;
    EXPECT_TRUE(i < kFirst + 27 || result.status.state == TrackingState::kLost) << i;
  }
  EXPECT_EQ(result.status.state, TrackingState::kTracking);
  EXPECT_LT(error(drive, kFirst + 24, T_odom_before, kFirst + 39, result.T_odom_base), 0.1);
}

// Bare ground holds no position. The pose stays at the prediction instead of running after
// the rings, which travel with the sensor.
TEST(FrontEndFaults, BareGroundDoesNotDisplaceThePose) {
  const simulation::Drive drive = drive_of("town");
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult result;
  Pose T_odom_before;
  for (std::size_t i = kFirst; i < kFirst + 20; ++i) {
    Scan scan = drive.base_scan(i);
    if (i == kFirst + 15) T_odom_before = result.T_odom_base;
    if (i >= kFirst + 15) scan.cloud = ground_of(scan.cloud);
    result = front_end.process(scan);
  }
  EXPECT_LT(error(drive, kFirst + 14, T_odom_before, kFirst + 19, result.T_odom_base), 0.4);
}

// Two seconds without sweeps: the next one is found where the vehicle is by then.
TEST(FrontEndFaults, ResumesAfterTwoSecondsWithoutSweeps) {
  const simulation::Drive drive = drive_of("town");
  constexpr std::size_t kGap = kFirst + 10;
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult result;
  Pose T_odom_before;
  for (std::size_t i = kFirst; i < kGap + 30; ++i) {
    if (i >= kGap && i < kGap + 20) continue;
    result = front_end.process(drive.base_scan(i));
    if (i == kGap - 1) T_odom_before = result.T_odom_base;
  }
  ASSERT_GT(true_motion(drive, kGap, kGap + 20).translation.norm(), 10.0);
  EXPECT_EQ(result.status.state, TrackingState::kTracking);
  EXPECT_LT(error(drive, kGap - 1, T_odom_before, kGap + 29, result.T_odom_base), 0.3);
}

/// Scans of a drive, and from one of them on those of another place, after a gap.
FrontEndResult with_gap(const simulation::Drive& drive, const simulation::Drive& elsewhere,
                        double gap, Pose& T_odom_before) {
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult result;
  for (std::size_t i = kFirst; i < kFirst + 25; ++i) result = front_end.process(drive.base_scan(i));
  T_odom_before = result.T_odom_base;
  Stamp stamp = result.stamp + from_seconds(gap);
  for (std::size_t i = 0; i < 5; ++i, stamp += from_seconds(kPeriod)) {
    result = front_end.process({stamp, elsewhere.base_scan(i).cloud});
    EXPECT_TRUE(is_valid_covariance(result.covariance)) << gap << " s, scan " << i;
  }
  return result;
}

// A recording that was paused and resumed at another place: the maps of both places lie side by
// side, upright, and are not taken for one.
TEST(FrontEndFaults, BeginsASegmentNearbyWhereARecordingWasResumedElsewhere) {
  const simulation::Drive drive = drive_of("town");
  const simulation::Drive elsewhere = drive_of("car_park");
  for (const double gap : {3.5, 8.0, 60.0, 600.0, 1.7e9}) {
    Pose T_odom_before;
    const FrontEndResult result = with_gap(drive, elsewhere, gap, T_odom_before);
    EXPECT_EQ(result.segment, 1U) << gap;
    EXPECT_EQ(result.status.state, TrackingState::kTracking) << gap;
    const Pose step = T_odom_before.inverse() * result.T_odom_base;
    EXPECT_LT(step.translation.norm(), 100.0) << gap;
    EXPECT_GT((step.rotation * Eigen::Vector3d::UnitZ()).z(), std::cos(2.0 * kRadPerDeg)) << gap;
  }
}

// The clock of a LiDAR that finds its master jumps by fifty years. The vehicle stands.
TEST(FrontEndFaults, ContinuesAtRestWhenTheClockIsSet) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const simulation::Drive drive = make_drive("town", 20.0, seed);
    FrontEnd front_end{FrontEndConfig{}};
    FrontEndResult result;
    for (std::size_t i = 0; i < 15; ++i) {
      const Stamp jump = i < 10 ? 0 : from_seconds(1.7e9);
      result = front_end.process({drive.scan_stamp(i) + jump, drive.base_scan(i).cloud});
    }
    EXPECT_EQ(result.status.state, TrackingState::kTracking) << seed;
    EXPECT_EQ(result.segment, 0U) << seed;
    EXPECT_LT(result.T_odom_base.translation.norm(), 0.05) << seed;
  }
}

// The first stamp of a bag may be older than the others by any time.
TEST(FrontEndFaults, FindsASecondScanAnHourLater) {
  const simulation::Drive drive = drive_of("town");
  FrontEnd front_end{FrontEndConfig{}};
  front_end.process(drive.base_scan(0));
  const FrontEndResult result =
      front_end.process({drive.scan_stamp(1) + from_seconds(3600.0), drive.base_scan(1).cloud});
  EXPECT_NE(result.status.state, TrackingState::kLost);
  EXPECT_LT(result.T_odom_base.translation.norm(), 0.1);
}

Vector6d true_twist(const simulation::Drive& drive, std::size_t index) {
  const Pose step = true_motion(drive, index, index + 1);
  Vector6d twist;
  twist << step.translation, log_so3(step.rotation);
  return twist / kPeriod;
}

/// The scheme of hdl_graph_slam: each scan against the last key frame alone. It is given the first
/// step and the true twists to deskew with. Returns T_from_to.
Pose against_single_key_frames(const simulation::Drive& drive, std::size_t from, std::size_t to) {
  registration::RegistrationConfig config;
  config.method = registration::Method::kVgicp;
  const auto registration = registration::make_registration(config);
  Pose T_from_key, T_key_last;
  Pose step = true_motion(drive, from, from + 1);
  for (std::size_t i = from; i <= to; ++i) {
    const PointCloud cloud =
        voxel_filtered(deskewed(drive.base_scan(i).cloud, true_twist(drive, i)), 0.4);
    if (i > from) {
      const Pose matched = registration->align(cloud, T_key_last * step).T_target_source;
      step = T_key_last.inverse() * matched;
      T_key_last = matched;
    }
    if (i > from && T_key_last.translation.norm() < 2.0) continue;
    T_from_key = T_from_key * T_key_last;
    T_key_last = Pose{};
    registration->set_target(cloud);
  }
  return T_from_key * T_key_last;
}

// Scans are matched with all that was seen, not with one key frame.
TEST(FrontEndFaults, DriftsLessThanScanToKeyFrame) {
  const simulation::Drive drive = drive_of("town");
  constexpr std::size_t kFrom = kFirst + 5;
  constexpr std::size_t kTo = kFrom + 40;
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult result;
  Pose T_odom_from;
  for (std::size_t i = kFirst; i <= kTo; ++i) {
    result = front_end.process(drive.base_scan(i));
    if (i == kFrom) T_odom_from = result.T_odom_base;
  }
  const double single =
      error(drive, kFrom, Pose{}, kTo, against_single_key_frames(drive, kFrom, kTo));
  EXPECT_LT(error(drive, kFrom, T_odom_from, kTo, result.T_odom_base), 0.5 * single) << single;
}

struct RideWithoutTimes {
  double error = 0.0;          ///< m, at the end
  std::size_t distrusted = 0;  ///< scans, since the times were found
};

/// Uncompensated scans without times; with the rate of a perfect gyro at the stamp, if `with_rate`.
RideWithoutTimes ride_without_times(const simulation::Drive& drive, bool with_rate) {
  EvaluatedDrive ride(drive);
  RideWithoutTimes outcome;
  bool found = false;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    Scan scan = lidar_scan(drive, i);
    scan.cloud.times.clear();
    MotionPrior prior;
    if (with_rate)
      prior.angular_velocity = drive.trajectory().state(scan.stamp).angular_velocity_base;
    const FrontEndStatus& status = ride.process(scan, prior).status;
    found = found || status.sweep_times.source == SweepTimes::kByAzimuth;
    outcome.distrusted += found && status.gyro_distrusted ? 1 : 0;
  }
  EXPECT_TRUE(found);
  outcome.error = ride.error();
  return outcome;
}

// On legs the rate at one instant is not the mean rate of the sweep. Taken for it, a gyro that is
// right was called wrong, and a drive on stairs ended metres off.
TEST(FrontEndFaults, DoesNotTakeARateAtTheStampForThatOfASweep) {
  for (const char* name : {"stairs", "running"}) {
    SCOPED_TRACE(name);
    const simulation::Drive drive = make_drive(name, 20.0);
    const RideWithoutTimes with_rate = ride_without_times(drive, true);
    EXPECT_EQ(with_rate.distrusted, 0U);
    EXPECT_LT(with_rate.error, ride_without_times(drive, false).error + 0.1);
  }
}

// Each pose comes with a covariance that is one and with the twist of the vehicle.
TEST(FrontEndFaults, ReportsCovarianceAndTwist) {
  const simulation::Drive drive = drive_of("town");
  FrontEnd front_end{FrontEndConfig{}};
  for (std::size_t i = kFirst; i < kFirst + 30; ++i) {
    const FrontEndResult result = front_end.process(drive.base_scan(i));
    if (i < kFirst + 5) continue;
    ASSERT_TRUE(is_valid_covariance(result.covariance)) << i;
    EXPECT_GT(result.covariance.diagonal().minCoeff(), 0.0);
    const Vector6d expected = true_twist(drive, i);
    EXPECT_TRUE(test::near(result.twist.head<3>(), expected.head<3>(), 0.5)) << i;
    EXPECT_TRUE(test::near(result.twist.tail<3>(), expected.tail<3>(), 0.1)) << i;
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
