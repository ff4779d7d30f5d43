// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "local_map/key_frame_window.hpp"
#include "matching/search_starts.hpp"
#include "tracking/sliding_window_tracker.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kPeriod = 0.1;  // s
constexpr double kRange = 30.0;  // m

/// A street along x between houses of all sizes. The same points for every scan, each with its own
/// noise.
class Street {
 public:
  Street() {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
    for (int i = 0; i < 20000; ++i) {
      points_.emplace_back(between(-40.0, 110.0), between(-8.0, 8.0), -1.7);
    }
    for (int house = 0; house < 80; ++house) {
      const Eigen::Vector3d size(between(1.0, 7.0), between(2.0, 4.0), between(1.0, 6.0));
      const double side = house % 2 == 0 ? 1.0 : -1.0;
      const Eigen::Vector3d corner(between(-40.0, 110.0), side * between(4.0, 8.0), -1.7);
      for (int i = 0; i < 600; ++i) {
        Eigen::Vector3d p(unit(engine), unit(engine), unit(engine));
        const int face = i % 3;
        if (face < 2) p[face] = std::round(p[face]);
        if (face == 2) p.y() = 0.0;  // the front has twice as many points
        p = p.cwiseProduct(size);
        points_.emplace_back(corner.x() + p.x(), corner.y() + side * p.y(), corner.z() + p.z());
      }
    }
  }

  /// What is seen from T_world_base in one instant.
  PointCloud seen_from(const Pose& T_world_base, unsigned seed) const {
    std::mt19937 engine(seed);
    std::normal_distribution<double> noise(0.0, 0.02);
    PointCloud cloud;
    const Pose T_base_world = T_world_base.inverse();
    for (const Eigen::Vector3d& p_world : points_) {
      const Eigen::Vector3d p = T_base_world * p_world;
      if (p.norm() > kRange) continue;
      cloud.points.push_back({static_cast<float>(p.x() + noise(engine)),
                              static_cast<float>(p.y() + noise(engine)),
                              static_cast<float>(p.z() + noise(engine)), 0.0F});
    }
    return cloud;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
};

const Street& street() {
  static const Street instance;
  return instance;
}

/// Drives along the street, swaying a little.
Pose pose_at(double speed, double seconds) {
  Vector6d d;
  d << speed * seconds, 0.3 * std::sin(0.8 * seconds), 0.0, 0.0, 0.0, 0.05 * std::sin(seconds);
  return perturbed(Pose::Identity(), d);
}

Scan scan_at(double speed, double seconds) {
  const auto seed = static_cast<unsigned>(1000.0 * seconds);
  return {from_seconds(seconds), street().seen_from(pose_at(speed, seconds), seed)};
}

FrontEndConfig config_for(registration::Method method) {
  FrontEndConfig config;
  config.registration.method = method;
  // The made-up street is sparse.
  config.frame_filter_resolution = 0.5;
  config.local_map_filter_resolution = 0.3;
  return config;
}

double error_of(const TrackedScan& tracked, double speed, double seconds) {
  return (tracked.T_odom_base.translation - pose_at(speed, seconds).translation).norm();
}

class SlidingWindow : public testing::TestWithParam<registration::Method> {};

TEST_P(SlidingWindow, TracksADrive) {
  SlidingWindowTracker tracker(config_for(GetParam()));
  const double speed = 8.0;
  for (int k = 0; k < 20; ++k) {
    const double t = kPeriod * k;
    const TrackedScan tracked = tracker.track(scan_at(speed, t), {});
    EXPECT_EQ(tracked.status.state, TrackingState::kTracking) << k;
    // Point to point lags behind by some percent.
    EXPECT_LT(error_of(tracked, speed, t), 0.1 + 0.03 * speed * t) << k;
    EXPECT_TRUE(k <= 5 || std::abs(tracked.twist[0] - speed) < 1.5) << k;
    EXPECT_TRUE(is_valid_covariance(tracked.covariance));
  }
}

INSTANTIATE_TEST_SUITE_P(All, SlidingWindow,
                         testing::Values(registration::Method::kNdt, registration::Method::kVgicp,
                                         registration::Method::kPclNdt, registration::Method::kIcp,
                                         registration::Method::kGicp),
                         [](const auto& instance) { return to_string(instance.param); });

TEST(SlidingWindowTracker, IsUsedByNdtIfConfigured) {
  FrontEndConfig config = config_for(registration::Method::kNdt);
  const auto is_window = [&] {
    const std::unique_ptr<Tracker> tracker = make_tracker(config);
    return dynamic_cast<SlidingWindowTracker*>(tracker.get()) != nullptr;
  };
  EXPECT_FALSE(is_window());
  config.local_map_method = LocalMapMethod::kSlidingWindow;
  EXPECT_TRUE(is_window());
}

// The prediction is one of velocity, by stamps.
TEST(SlidingWindowTracker, ToleratesMissingScansAtSpeed) {
  SlidingWindowTracker tracker(config_for(registration::Method::kVgicp));
  std::mt19937 engine(3);
  const double speed = 20.0;
  for (int k = 0; k < 30; ++k) {
    if (k > 3 && engine() % 10 < 3) continue;
    const double t = kPeriod * k;
    EXPECT_LT(error_of(tracker.track(scan_at(speed, t), {}), speed, t), 0.2) << k;
  }
}

// What does not fit is reported lost and held at the prediction, and found again.
TEST(SlidingWindowTracker, IsLostWithoutPointsAndRecovers) {
  SlidingWindowTracker tracker(config_for(registration::Method::kVgicp));
  const double speed = 6.0;
  for (int k = 0; k < 30; ++k) {
    const double t = kPeriod * k;
    Scan scan = scan_at(speed, t);
    const bool blind = k >= 10 && k < 15;
    if (blind) {  // a lorry beside and before the sensor
      for (Point& p : scan.cloud.points) p = {2.0F + 0.01F * p.x, 0.02F * p.y, 30.0F + p.z, 0.0F};
    }
    const TrackedScan tracked = tracker.track(scan, {});
    EXPECT_EQ(tracked.status.state == TrackingState::kLost, blind) << k;
    EXPECT_LT(error_of(tracked, speed, t), blind ? 0.5 : 0.2) << k;
  }
}

TEST(SlidingWindowTracker, StartsANewSegmentAfterBeingLostTooLong) {
  FrontEndConfig config = config_for(registration::Method::kVgicp);
  config.max_lost_time = 0.5;
  SlidingWindowTracker tracker(config);
  const double speed = 6.0;
  bool new_segment = false;
  for (int k = 0; k < 20; ++k) {
    Scan scan = scan_at(speed, kPeriod * k);
    if (k >= 10) {
      for (Point& p : scan.cloud.points) p = {p.z, 0.3F * p.x + 200.0F, p.y, 0.0F};
    }
    new_segment = tracker.track(scan, {}).new_segment || new_segment;
    EXPECT_FALSE(new_segment && k < 10);
  }
  EXPECT_TRUE(new_segment);
}

TEST(SlidingWindowTracker, UsesMeasuredVelocitiesInThePrediction) {
  const double speed = 12.0;
  MotionPrior prior;
  prior.linear_velocity = Eigen::Vector3d(speed, 0.0, 0.0);
  prior.angular_velocity = Eigen::Vector3d::Zero();
  SlidingWindowTracker tracker(config_for(registration::Method::kVgicp));
  tracker.track(scan_at(speed, 0.0), prior);
  // Nothing to match: the pose is the prediction.
  const TrackedScan tracked = tracker.track({from_seconds(0.5), {}}, prior);
  EXPECT_EQ(tracked.status.state, TrackingState::kLost);
  EXPECT_NEAR(tracked.T_odom_base.translation.x(), 6.0, 1e-9);
}

// A pause of the recording, or a clock that was set: nobody drives straight on for so long.
TEST(SlidingWindowTracker, PredictsNoLongWayOverAGap) {
  MotionPrior prior;
  prior.linear_velocity = Eigen::Vector3d(12.0, 0.0, 0.0);
  prior.angular_velocity = Eigen::Vector3d::Zero();
  SlidingWindowTracker tracker(config_for(registration::Method::kVgicp));
  tracker.track(scan_at(12.0, 0.0), prior);
  const TrackedScan tracked = tracker.track({from_seconds(600.0), {}}, prior);
  EXPECT_NEAR(tracked.T_odom_base.translation.x(), 60.0, 1e-9);
}

TEST(SlidingWindowTracker, SearchesNoLongerIfTheSecondScanComesLate) {
  FrontEndConfig config = config_for(registration::Method::kVgicp);
  config.frame_filter_resolution = 4.0;  // few points: only the number of starts counts
  const auto searched_for = [&config](double gap) {
    SlidingWindowTracker tracker(config);
    tracker.track(scan_at(0.0, 0.0), {});
    Scan second = scan_at(0.0, 0.1);
    second.stamp = from_seconds(gap);
    const auto begin = std::chrono::steady_clock::now();
    tracker.track(second, {});
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const double usual = searched_for(kLongestSearchedTime);
  EXPECT_LT(searched_for(20.0 * kLongestSearchedTime), 5.0 * usual);
}

// Two instances know nothing of each other, and a restart forgets all.
TEST(SlidingWindowTracker, DiscardsEverythingOnRestart) {
  SlidingWindowTracker used(config_for(registration::Method::kVgicp));
  for (int k = 0; k < 4; ++k) used.track(scan_at(9.0, kPeriod * k), {});
  used.restart();
  SlidingWindowTracker fresh(config_for(registration::Method::kVgicp));
  for (int k = 4; k < 8; ++k) {
    const Scan scan = scan_at(9.0, kPeriod * k);
    EXPECT_EQ(used.track(scan, {}).T_odom_base.matrix(), fresh.track(scan, {}).T_odom_base.matrix())
        << k;
  }
}

TEST(KeyFrameWindow, DropsTheOldestAndThinsOutFromHalfAWindowOn) {
  KeyFrameWindow window(4, 1.0);
  PointCloud cloud;
  cloud.points.assign(5, {0.1F, 0.1F, 0.1F, 0.0F});
  window.push(Pose::Identity(), cloud);
  EXPECT_EQ(window.joint_cloud(Pose::Identity()).size(), 5U);
  for (int k = 1; k < 7; ++k) {
    window.push({Eigen::Quaterniond::Identity(), {10.0 * k, 0.0, 0.0}}, cloud);
  }
  const PointCloud joint = window.joint_cloud(window.newest_pose().inverse());
  ASSERT_EQ(joint.size(), 4U);
  EXPECT_NEAR(joint.points.front().x, -29.9F, 1e-4F);
  EXPECT_NEAR(joint.points.back().x, 0.1F, 1e-4F);
}

}  // namespace
}  // namespace lidar_mapping::front_end
