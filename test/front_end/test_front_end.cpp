// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/front_end/deskew.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "evaluated_drive.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr Stamp kScanPeriod = 100'000'000;

simulation::Drive town() { return make_drive("town", 20.0); }

/// Distance (m) from where the sensor really is.
double error(const simulation::Drive& drive, std::size_t first, std::size_t index,
             const FrontEndResult& result) {
  return (result.T_odom_base.translation - true_motion(drive, first, index).translation).norm();
}

Scan empty_scan(const simulation::Drive& drive, std::size_t index) {
  Scan scan;
  scan.stamp = drive.scan_stamp(index);
  return scan;
}

TEST(FrontEnd, TracksADrive) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  for (std::size_t i = 0; i < 120; ++i) {
    const Scan scan = drive.base_scan(i);
    const FrontEndResult result = front_end.process(scan);
    ASSERT_EQ(result.stamp, scan.stamp);
    ASSERT_NE(result.status.state, TrackingState::kLost) << i;
    ASSERT_LT(error(drive, 0, i, result), 0.08) << i;
    ASSERT_TRUE(i == 0 || is_valid_covariance(result.covariance)) << i;
  }
}

// Nothing about the motion is known at first, and scans go missing on the way.
TEST(FrontEnd, StartsAtSpeedAndToleratesMissingScans) {
  const simulation::Drive drive = town();
  constexpr std::size_t kFirst = 100;
  FrontEnd front_end{FrontEndConfig{}};
  for (std::size_t i = kFirst; i < 180; ++i) {
    if (i > kFirst + 5 && (i * 7) % 10 < 3) continue;
    const FrontEndResult result = front_end.process(drive.base_scan(i));
    // Sixteen beams, a first map from one scan: a hundredth of the way, most of it the heading.
    const double way = true_motion(drive, kFirst, i).translation.norm();
    ASSERT_LT(error(drive, kFirst, i, result), 0.1 + 0.015 * way) << i;
  }
}

/// What a recording gives that begins in motion: preprocessing compensates from the second scan on.
TEST(FrontEnd, DeskewsTheFirstScanWithTheMotionFromTheSecond) {
  const simulation::Drive drive = town();
  for (const std::size_t first : {140, 160, 180}) {
    FrontEnd front_end{FrontEndConfig{}};
    front_end.process(drive.base_scan(first));
    const auto motion = drive.trajectory().state(drive.scan_stamp(first + 1));
    Vector6d twist;
    twist << motion.T_map_base.rotation.conjugate() * motion.velocity_map,
        motion.angular_velocity_base;
    Scan second = drive.base_scan(first + 1);
    second.cloud = deskewed(second.cloud, twist);
    MotionPrior prior;
    prior.linear_velocity = twist.head<3>();
    prior.angular_velocity = twist.tail<3>();
    EXPECT_LT(error(drive, first, first + 1, front_end.process(second, prior)), 0.05) << first;
  }
}

TEST(FrontEnd, StandsStillAmongMovingCars) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  Scan scan = drive.base_scan(0);
  std::size_t key_frames = 0;
  for (int i = 0; i < 20; ++i) {
    scan = drive.base_scan(static_cast<std::size_t>(i));  // the drive begins at rest
    const FrontEndResult result = front_end.process(scan);
    key_frames += result.key_frame ? 1 : 0;
    ASSERT_TRUE(test::near(result.T_odom_base.translation, Eigen::Vector3d::Zero(), 0.02)) << i;
  }
  EXPECT_EQ(key_frames, 1U);
}

// Scans without points are reported as lost, the pose goes on as predicted with a growing
// covariance, and the pose is found again with the next points.
TEST(FrontEnd, ReportsLostTrackingAndRecovers) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult result;
  double covariance_before = 0.0;
  for (std::size_t i = 60; i < 110; ++i) {
    const bool blind = i >= 90 && i < 98;
    result = front_end.process(blind ? empty_scan(drive, i) : drive.base_scan(i));
    if (i == 89) covariance_before = result.covariance.trace();
    if (blind) {
      EXPECT_EQ(result.status.state, TrackingState::kLost) << i;
      EXPECT_FALSE(result.key_frame) << i;
      EXPECT_GT(result.covariance.trace(), covariance_before);
    }
  }
  EXPECT_EQ(result.status.state, TrackingState::kTracking);
  EXPECT_LT(error(drive, 60, 109, result), 0.25);
}

TEST(FrontEnd, StartsANewSegmentAfterBeingLostTooLong) {
  const simulation::Drive drive = town();
  simulation::DriveOptions options;
  options.drive = "car_park";
  options.lidar = "vlp16";
  const simulation::Drive elsewhere(options);
  FrontEnd front_end{FrontEndConfig{}};
  for (std::size_t i = 0; i < 10; ++i) front_end.process(drive.base_scan(i));
  std::vector<std::uint32_t> segments;
  for (std::size_t i = 10; i < 60; ++i) {
    Scan scan = i < 50 ? empty_scan(drive, i) : elsewhere.base_scan(i);
    scan.stamp = drive.scan_stamp(i);
    const FrontEndResult result = front_end.process(scan);
    if (result.key_frame) segments.push_back(result.key_frame->segment);
  }
  ASSERT_FALSE(segments.empty());
  EXPECT_EQ(segments.back(), 1U);
}

// The sensor sees nothing until the wheels have carried it so far that nothing is left of its map.
TEST(FrontEnd, ContinuesAtItsPoseIfItLeftItsMapWithoutPoints) {
  const simulation::Drive drive = town();
  FrontEndConfig config;
  config.local_map_radius = 5.0;
  FrontEnd front_end{config};
  FrontEndResult last;
  for (std::size_t i = 60; i < 75; ++i) last = front_end.process(drive.base_scan(i));
  const std::uint32_t segment = last.segment;
  const double distance = last.T_odom_base.translation.norm();
  MotionPrior wheels;
  wheels.linear_velocity = {10.0, 0.0, 0.0};
  for (Stamp i = 1; i <= 150; ++i) front_end.process({last.stamp + i * kScanPeriod, {}}, wheels);
  ASSERT_EQ(front_end.local_map().size(), 0u);
  Scan scan = drive.base_scan(75);
  scan.stamp = last.stamp + 151 * kScanPeriod;
  const FrontEndResult seeing = front_end.process(scan);
  EXPECT_EQ(seeing.segment, segment + 1);
  EXPECT_EQ(seeing.status.state, TrackingState::kLost);
  EXPECT_GT(seeing.T_odom_base.translation.norm(), distance);
}

// Nothing is kept outside of the object.
TEST(FrontEnd, TwoInstancesAreIndependent) {
  const simulation::Drive drive = town();
  FrontEnd alone{FrontEndConfig{}};
  FrontEnd one{FrontEndConfig{}};
  FrontEnd other{FrontEndConfig{}};
  for (std::size_t i = 0; i < 15; ++i) {
    const FrontEndResult expected = alone.process(drive.base_scan(i));
    const FrontEndResult result = one.process(drive.base_scan(i));
    other.process(drive.base_scan(100 + i));
    ASSERT_EQ(expected.T_odom_base.matrix(), result.T_odom_base.matrix()) << i;
  }
}

TEST(FrontEnd, PosesDoNotDependOnTheNumberOfThreads) {
  const simulation::Drive drive = town();
  FrontEndConfig config;
  FrontEnd one(config);
  config.threads = 4;
  FrontEnd four(config);
  for (std::size_t i = 0; i < 15; ++i) {
    const FrontEndResult a = one.process(drive.base_scan(i));
    const FrontEndResult b = four.process(drive.base_scan(i));
    ASSERT_EQ(a.T_odom_base.matrix(), b.T_odom_base.matrix()) << i;
    if (a.key_frame) {
      ASSERT_EQ(a.key_frame->cloud->size(), b.key_frame->cloud->size());
    }
  }
}

TEST(FrontEnd, RejectsStampsThatDoNotIncrease) {
  FrontEnd front_end{FrontEndConfig{}};
  Scan scan;
  scan.stamp = kScanPeriod;
  front_end.process(scan);
  EXPECT_THROW(front_end.process(scan), InputError);
}

TEST(FrontEnd, SumsUpTheCovariancesOfTheSteps) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  FrontEndResult last = front_end.process(drive.base_scan(0));
  EXPECT_TRUE(front_end.pose_covariance().isZero(0.0)) << "the first pose is known by definition";
  Covariance6 expected = Covariance6::Zero();
  for (std::size_t i = 1; i < 10; ++i) {
    const FrontEndResult result = front_end.process(drive.base_scan(i));
    expected = compose_covariance(expected, last.T_odom_base.inverse() * result.T_odom_base,
                                  result.covariance);
    EXPECT_EQ(front_end.pose_covariance(), expected) << i;
    last = result;
  }
}

TEST(FrontEnd, ContinuesNumberingAfterARestart) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  Pose start;
  start.translation = {100.0, 50.0, 1.0};
  front_end.resume(42, 3, start);
  EXPECT_EQ(front_end.process(drive.base_scan(0)).T_odom_base.matrix(), start.matrix());
  const FrontEndResult result = front_end.process(drive.base_scan(1));
  ASSERT_TRUE(result.key_frame);
  EXPECT_EQ(result.key_frame->index, 42U);
  EXPECT_EQ(result.key_frame->segment, 3U);
}

TEST(FrontEnd, MakesNoKeyFrameFromAScanThatCannotBeDeskewed) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  EXPECT_FALSE(front_end.process(drive.base_scan(0)).key_frame) << "the motion is not known yet";
  const FrontEndResult second = front_end.process(drive.base_scan(1));
  EXPECT_TRUE(second.key_frame);
  ASSERT_EQ(second.finalized.size(), 1U);
  EXPECT_FALSE(second.finalized[0].key_frame) << "the drive begins at rest: there are others";

  Scan without_times = drive.base_scan(0);
  without_times.cloud.times.clear();
  FrontEnd other{FrontEndConfig{}};
  EXPECT_TRUE(other.process(without_times).provisional);
  const std::vector<FrontEndResult> finalized = other.finalize();
  ASSERT_EQ(finalized.size(), 1U);
  EXPECT_TRUE(finalized[0].key_frame);
  EXPECT_TRUE(other.finalize().empty());
}

/// What becomes of the scans from `first` on, until the first one that is not provisional.
std::vector<FrontEndResult> finalized_from(const simulation::Drive& drive, std::size_t first,
                                           FrontEnd& front_end) {
  for (std::size_t i = first;; ++i) {
    const FrontEndResult result = front_end.process(drive.base_scan(i));
    if (!result.provisional) return result.finalized;
    EXPECT_TRUE(result.finalized.empty());
    EXPECT_FALSE(result.key_frame);
  }
}

TEST(FrontEnd, RematchesTheFirstScansOfADriveThatBeginsAtSpeed) {
  const simulation::Drive drive = town();
  constexpr std::size_t kFirst = 120;
  FrontEnd front_end{FrontEndConfig{}};
  const std::vector<FrontEndResult> finalized = finalized_from(drive, kFirst, front_end);
  ASSERT_GT(finalized.size(), 10U);
  EXPECT_LT(finalized.size(), 72U) << "seven seconds";
  KeyFrameIndex key_frames = 0;
  for (std::size_t i = 0; i < finalized.size(); ++i) {
    EXPECT_EQ(finalized[i].stamp, drive.scan_stamp(kFirst + i));
    EXPECT_FALSE(finalized[i].provisional);
    if (!finalized[i].key_frame) continue;
    EXPECT_EQ(finalized[i].key_frame->index, key_frames++);
    EXPECT_EQ(finalized[i].key_frame->stamp, finalized[i].stamp);
    EXPECT_EQ(finalized[i].key_frame->T_odom_base.matrix(), finalized[i].T_odom_base.matrix());
    EXPECT_FALSE(finalized[i].key_frame->cloud->has_times());
  }
  EXPECT_TRUE(finalized[0].key_frame) << "its motion is known now";
  EXPECT_GT(key_frames, 6U);
}

TEST(FrontEnd, FirstScansAreFinalIfNoScanFollows) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  std::vector<Pose> provisional;
  for (std::size_t i = 150; i < 155; ++i) {
    provisional.push_back(front_end.process(drive.base_scan(i)).T_odom_base);
  }
  const std::vector<FrontEndResult> finalized = front_end.finalize();
  ASSERT_EQ(finalized.size(), provisional.size());
  for (std::size_t i = 0; i < finalized.size(); ++i) {
    EXPECT_EQ(finalized[i].T_odom_base.matrix(), provisional[i].matrix());
  }
  EXPECT_FALSE(finalized[0].key_frame) << "it cannot be deskewed";
  EXPECT_TRUE(finalized[1].key_frame);
  const FrontEndResult next = front_end.process(drive.base_scan(155));
  EXPECT_FALSE(next.provisional);
  EXPECT_TRUE(next.finalized.empty());
}

TEST(FrontEnd, FirstScansAreFinalIfTrackingIsLost) {
  const simulation::Drive drive = town();
  FrontEnd front_end{FrontEndConfig{}};
  for (std::size_t i = 150; i < 155; ++i) front_end.process(drive.base_scan(i));
  const FrontEndResult lost = front_end.process(empty_scan(drive, 155));
  EXPECT_EQ(lost.status.state, TrackingState::kLost);
  EXPECT_FALSE(lost.provisional);
  EXPECT_EQ(lost.finalized.size(), 5U);
}

TEST(FrontEnd, KeyFramesFollowAnExternalOdometry) {
  FrontEndConfig config;
  config.odometry = OdometrySource::kExternal;
  FrontEnd front_end(config);
  std::size_t key_frames = 0;
  for (int i = 0; i < 41; ++i) {
    Scan scan;
    scan.stamp = (i + 1) * kScanPeriod;
    MotionPrior prior;
    prior.T_external_base = Pose{Eigen::Quaterniond::Identity(), {0.5 * i, 0.0, 0.0}};
    const FrontEndResult result = front_end.process(scan, prior);
    key_frames += result.key_frame ? 1 : 0;
    if (i == 0) continue;
    // Two per cent of half a metre and a little more.
    EXPECT_GT(std::sqrt(result.covariance(0, 0)), 0.001);
    EXPECT_LT(std::sqrt(result.covariance(0, 0)), 0.05);
    EXPECT_TRUE(is_valid_covariance(result.covariance));
  }
  EXPECT_EQ(key_frames, 11U);
  Scan late;
  late.stamp = 50 * kScanPeriod;
  EXPECT_THROW(front_end.process(late), InputError);
}

/// The first pose of a front end that is given a pose by the user, by GNSS or by both.
Pose begun(const FrontEndConfig& config, const std::optional<Pose>& by_user, const Pose& by_gnss) {
  FrontEnd front_end(config);
  if (by_user) front_end.set_initial_pose(*by_user);
  MotionPrior prior;
  prior.T_odom_base_initial = by_gnss;
  prior.T_external_base = Pose{Eigen::Quaterniond::Identity(), {50.0, 0.0, 0.0}};
  static const Scan scan = town().base_scan(0);
  const FrontEndResult result = front_end.process(scan, prior);
  EXPECT_THROW(front_end.set_initial_pose(Pose::Identity()), InputError) << "it has begun";
  return result.T_odom_base;
}

TEST(FrontEnd, StartsAtTheConfiguredPoseOrElseAtTheGnssPose) {
  const Pose by_gnss{Eigen::Quaterniond::Identity(), {7.0, 7.0, 7.0}};
  const Pose by_user{Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ())),
                     {3.0, -2.0, 0.5}};
  FrontEndConfig config;
  const auto distance = [](const Pose& a, const Pose& b) { return difference(a, b).norm(); };
  EXPECT_LT(distance(begun(config, std::nullopt, by_gnss), by_gnss), 1e-9);
  EXPECT_LT(distance(begun(config, by_user, by_gnss), by_user), 1e-9);
  config.initial_pose = {3.0, -2.0, 0.5, 0.0, 0.0, 0.5 * M_PI};
  for (const OdometrySource source : {OdometrySource::kLidar, OdometrySource::kExternal}) {
    config.odometry = source;
    EXPECT_LT(distance(begun(config, std::nullopt, by_gnss), by_user), 1e-9);
  }
  config.odometry = OdometrySource::kLidar;
  config.registration.method = registration::Method::kVgicp;
  EXPECT_LT(distance(begun(config, std::nullopt, by_gnss), by_user), 1e-9);
}

// Neither a configured pose nor GNSS moves it: odometry has drifted away from both.
TEST(FrontEnd, ContinuesAtItsPoseAfterARestart) {
  const Pose last{Eigen::Quaterniond::Identity(), {100.0, 0.0, 0.0}};
  const Scan scan = town().base_scan(0);
  MotionPrior prior;
  prior.T_odom_base_initial = Pose{Eigen::Quaterniond::Identity(), {7.0, 7.0, 7.0}};
  for (const double configured : {0.0, 3.0}) {
    FrontEndConfig config;
    config.initial_pose = {configured, 0.0, 0.0, 0.0, 0.0, 0.0};
    FrontEnd front_end(config);
    front_end.resume(7, 1, last);
    EXPECT_NEAR(front_end.process(scan, prior).T_odom_base.translation.x(), 100.0, 1e-9);
  }
}

/// A plain and a wall, finer than the voxels.
Scan wide_scan(double reach) {
  Scan scan;
  scan.stamp = kScanPeriod;
  const auto add = [&](double x, double y, double z) {
    scan.cloud.points.push_back(
        {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0.0F});
  };
  for (double x = -reach; x < reach; x += 0.2) {
    for (double y = -reach; y < reach; y += 0.2) add(x, y, -1.7);
  }
  return scan;
}

TEST(FrontEnd, CountsPointsDroppedByAFullLocalMap) {
  FrontEndConfig config;
  const Scan scan = wide_scan(60.0);
  EXPECT_EQ(FrontEnd(config).process(scan).status.map_points_dropped, 0U);
  config.voxel_size = config.insertion_resolution = 0.2;
  EXPECT_GT(FrontEnd(config).process(scan).status.map_points_dropped, 10000U);
}

TEST(FrontEnd, ThinsOutTheCloudsOfKeyFrames) {
  const simulation::Drive drive = town();
  FrontEndConfig config;
  config.key_frame_cloud_resolution = 0.0;
  const Scan scan = drive.base_scan(1);
  const auto first_cloud = [&] {
    FrontEnd front_end(config);
    front_end.process(drive.base_scan(0));
    return front_end.process(scan).key_frame->cloud;
  };
  EXPECT_EQ(first_cloud()->size(), scan.cloud.size());
  config.key_frame_cloud_resolution = 0.5;
  const auto thinned = first_cloud();
  EXPECT_LT(thinned->size(), scan.cloud.size() / 2);
  EXPECT_FALSE(thinned->has_times());
}

// The tunnel is reported, and the measured speed leads through it.
TEST(FrontEnd, ReportsATunnelAndUsesTheVelocityThere) {
  simulation::DriveOptions options;
  options.drive = "tunnel";
  options.lidar = "vlp16";
  const simulation::Drive drive(options);
  const std::size_t first = drive.scan_count() / 2 - 40;
  FrontEnd front_end{FrontEndConfig{}};
  std::size_t degenerate = 0;
  FrontEndResult result;
  for (std::size_t i = first; i < first + 80; ++i) {
    MotionPrior prior;
    const Pose step = true_motion(drive, i - 1, i + 1);
    prior.linear_velocity = step.translation / (2.0 * to_seconds(kScanPeriod));
    result = front_end.process(drive.base_scan(i), prior);
    degenerate += result.status.degenerate_directions.empty() ? 0 : 1;
  }
  EXPECT_GT(degenerate, 20U);
  EXPECT_LT(error(drive, first, first + 79, result),
            0.01 * true_motion(drive, first, first + 79).translation.norm());
}

}  // namespace
}  // namespace lidar_mapping::front_end
