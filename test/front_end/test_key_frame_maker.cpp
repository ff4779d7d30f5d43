// SPDX-License-Identifier: BSD-3-Clause
// What becomes a key frame, with a tracker that follows an external odometry.

#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "error_text.hpp"
#include "key_frame_maker.hpp"
#include "tracking/external_tracker.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr Stamp kSecond = 1'000'000'000;

FrontEndConfig every_two_metres() {
  FrontEndConfig config;
  config.key_frame_distance = 2.0;
  config.key_frame_angle = 0.5;
  config.key_frame_interval = 0.0;
  config.key_frame_cloud_resolution = 0.0;
  return config;
}

TrackedScan scan_at(double x, TrackingState state = TrackingState::kTracking) {
  TrackedScan tracked;
  tracked.T_odom_base.translation.x() = x;
  tracked.status.state = state;
  return tracked;
}

MotionPrior external_at(double x) {
  MotionPrior prior;
  prior.T_external_base = Pose{Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}};
  return prior;
}

TEST(ExternalTracker, BeginsAtTheFirstPose) {
  ExternalTracker tracker;
  EXPECT_EQ(tracker.track({kSecond, {}}, external_at(5.0)).T_odom_base.translation.x(), 0.0);
  EXPECT_EQ(tracker.track({2 * kSecond, {}}, external_at(8.0)).T_odom_base.translation.x(), 3.0);
  tracker.restart();
  EXPECT_EQ(tracker.track({3 * kSecond, {}}, external_at(9.0)).T_odom_base.translation.x(), 0.0);
}

TEST(ExternalTracker, AsksForTheOdometryThatIsMissing) {
  ExternalTracker tracker;
  EXPECT_EQ(test::error_text<InputError>([&] {
              tracker.track({kSecond, {}}, {});
            }),
            "front_end: no external odometry for stamp 1000000000 ns; give "
            "MotionPrior::T_external_base or set odometry: lidar");
}

TEST(ExternalTracker, IsLessCertainOfLongSteps) {
  const ExternalTracker tracker;
  const auto sigma = [&](double x) {
    return std::sqrt(tracker.covariance_of_step(scan_at(0.0), scan_at(x))(0, 0));
  };
  EXPECT_NEAR(sigma(0.0), 0.005, 1e-12);
  EXPECT_NEAR(sigma(10.0), 0.205, 1e-12);
}

TEST(KeyFrameMaker, TakesTheFirstScanAndThenOneEveryTwoMetres) {
  KeyFrameMaker maker(every_two_metres());
  const ExternalTracker tracker;
  EXPECT_TRUE(maker.is_due(kSecond, false, scan_at(0.0)));
  const KeyFrame first = maker.make(kSecond, 4, scan_at(0.0), {}, tracker);
  EXPECT_EQ(first.index, 0u);
  EXPECT_EQ(first.segment, 4u);
  EXPECT_FALSE(maker.is_due(2 * kSecond, false, scan_at(1.9)));
  EXPECT_TRUE(maker.is_due(2 * kSecond, false, scan_at(2.1)));
  const KeyFrame second = maker.make(2 * kSecond, 4, scan_at(2.1), {}, tracker);
  EXPECT_EQ(second.index, 1u);
  EXPECT_EQ(second.motion_covariance, tracker.covariance_of_step(scan_at(0.0), scan_at(2.1)));
}

TEST(KeyFrameMaker, TakesNoScanThatCannotBeTrusted) {
  KeyFrameMaker maker(every_two_metres());
  EXPECT_FALSE(maker.is_due(kSecond, false, scan_at(0.0, TrackingState::kLost)));
  TrackedScan unknown_motion = scan_at(0.0);
  unknown_motion.motion_known = false;
  EXPECT_FALSE(maker.is_due(kSecond, true, unknown_motion));
  EXPECT_TRUE(maker.is_due(kSecond, false, unknown_motion));
}

TEST(KeyFrameMaker, TakesADegradedScanOnlyAfterALongTime) {
  KeyFrameMaker maker(every_two_metres());
  maker.make(kSecond, 0, scan_at(0.0), {}, ExternalTracker());
  EXPECT_FALSE(maker.is_due(2 * kSecond, false, scan_at(5.9, TrackingState::kDegraded)));
  EXPECT_TRUE(maker.is_due(2 * kSecond, false, scan_at(6.1, TrackingState::kDegraded)));
}

TEST(KeyFrameMaker, MarksAMotionWithADoubtfulStep) {
  KeyFrameMaker maker(every_two_metres());
  const ExternalTracker tracker;
  TrackedScan doubtful = scan_at(1.0, TrackingState::kDoubtful);
  doubtful.status.expected_error = 0.3;
  maker.make(kSecond, 0, scan_at(0.0), {}, tracker);
  maker.add_step(scan_at(0.0), doubtful);
  maker.add_step(doubtful, scan_at(2.1));
  const KeyFrame marked = maker.make(2 * kSecond, 0, scan_at(2.1), {}, tracker);
  EXPECT_TRUE(marked.doubtful);
  EXPECT_GT(marked.motion_covariance(0, 0),
            tracker.covariance_of_step(scan_at(0.0), scan_at(2.1))(0, 0));
  maker.add_step(scan_at(2.1), scan_at(4.2));
  EXPECT_FALSE(maker.make(3 * kSecond, 0, scan_at(4.2), {}, tracker).doubtful);
}

TEST(KeyFrameMaker, BeginsAgainWithASegment) {
  KeyFrameMaker maker(every_two_metres());
  const ExternalTracker tracker;
  maker.make(kSecond, 0, scan_at(0.0), {}, tracker);
  maker.start_segment();
  EXPECT_TRUE(maker.is_due(2 * kSecond, false, scan_at(0.1)));
  EXPECT_EQ(maker.make(2 * kSecond, 1, scan_at(0.1), {}, tracker).index, 1u);
  maker.resume(7);
  EXPECT_EQ(maker.make(3 * kSecond, 2, scan_at(0.2), {}, tracker).index, 7u);
}

TEST(KeyFrameMaker, ThinsOutAndRaisesThePoints) {
  FrontEndConfig config = every_two_metres();
  config.key_frame_cloud_resolution = 0.5;
  KeyFrameMaker maker(config);
  PointCloud cloud;
  for (int i = 0; i < 100; ++i)
    cloud.points.push_back({10.0f, 0.001f * static_cast<float>(i), 0.0f, 0.0f});
  TrackedScan tracked = scan_at(0.0);
  const PointCloud thinned = maker.points_of(cloud, tracked);
  EXPECT_LT(thinned.size(), 3u);
  tracked.correction.elevation_shift = 0.01;
  const PointCloud raised = maker.points_of(cloud, tracked);
  ASSERT_EQ(raised.size(), thinned.size());
  EXPECT_NEAR(raised.points[0].z, 0.1, 1e-4);
}

}  // namespace
}  // namespace lidar_mapping::front_end
