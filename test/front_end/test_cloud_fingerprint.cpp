// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/cloud_fingerprint.hpp"

#include "motion/coasting.hpp"

namespace lidar_mapping::front_end {
namespace {

PointCloud cloud_of(std::size_t size) {
  PointCloud cloud;
  for (std::size_t i = 0; i < size; ++i) {
    const auto f = static_cast<float>(i);
    cloud.points.push_back({0.37F * f, 5.0F - 0.011F * f, 0.2F, f});
  }
  return cloud;
}

TEST(CloudFingerprint, TellsTheSameCloudFromOthers) {
  PointCloud cloud = cloud_of(3000);
  const auto first = cloud_fingerprint(cloud);
  ASSERT_TRUE(first);
  EXPECT_EQ(cloud_fingerprint(cloud), first);
  PointCloud moved = cloud;
  for (Point& point : moved.points) point.x += 0.001F;
  EXPECT_NE(cloud_fingerprint(moved), first);
  cloud.points.pop_back();
  EXPECT_NE(cloud_fingerprint(cloud), first);
}

TEST(CloudFingerprint, IgnoresIntensitiesAndTheLastBits) {
  PointCloud cloud = cloud_of(3000);
  const auto before = cloud_fingerprint(cloud);
  for (Point& point : cloud.points) {
    point.intensity += 1.0F;
    point.y *= 1.0F + std::numeric_limits<float>::epsilon();
  }
  // A coordinate may lie between two steps; those of this cloud do not.
  EXPECT_EQ(cloud_fingerprint(cloud), before);
}

TEST(CloudFingerprint, ReadsPointsInTheLayoutOfADriver) {
  const PointCloud cloud = cloud_of(1000);
  constexpr std::size_t kBefore = 3, kStep = 22;  // bytes: nothing is aligned
  std::vector<unsigned char> bytes(kBefore + kStep * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    std::memcpy(&bytes[kBefore + kStep * i], &cloud.points[i], 3 * sizeof(float));
  EXPECT_EQ(cloud_fingerprint(bytes.data() + kBefore, kStep, cloud.size()),
            cloud_fingerprint(cloud));
}

// A cloud of 16 rings that is stored firing by firing; the first ring sees only the sky.
TEST(CloudFingerprint, SeesChangesBesideARingWithoutPoints) {
  PointCloud cloud = cloud_of(16 * 1792);
  for (std::size_t i = 0; i < cloud.size(); i += 16)
    cloud.points[i].x = cloud.points[i].y = std::numeric_limits<float>::quiet_NaN();
  const auto before = cloud_fingerprint(cloud);
  ASSERT_TRUE(before);
  for (Point& point : cloud.points) point.x += 0.5F;
  EXPECT_NE(cloud_fingerprint(cloud), before);
}

// As in a field: nearly all rays of an organised cloud are without a return, and equal.
TEST(CloudFingerprint, IsEmptyIfThereAreHardlyAnyReturns) {
  EXPECT_FALSE(cloud_fingerprint(cloud_of(10)));
  EXPECT_FALSE(cloud_fingerprint({}));
  for (const float none : {0.0F, std::numeric_limits<float>::quiet_NaN()}) {
    PointCloud cloud = cloud_of(20000);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (i % 100 != 0) cloud.points[i] = {none, none, none, 0.0F};
    EXPECT_FALSE(cloud_fingerprint(cloud));
  }
}

TEST(Coasting, ContinuesTheMotionWithGrowingCovariance) {
  TrackedScan tracked;
  tracked.covariance = diagonal_covariance(0.01, 0.001);
  tracked.twist << 10.0, 0.0, 0.0, 0.0, 0.0, 0.5;
  tracked.status.state = TrackingState::kTracking;
  double last_variance = tracked.covariance.trace();
  for (const double seconds : {0.1, 0.2, 1.0}) {
    const TrackedScan coasting = coasted(tracked, seconds);
    EXPECT_EQ(coasting.status.state, TrackingState::kLost);
    EXPECT_TRUE(coasting.status.repeated);
    EXPECT_NEAR(coasting.T_odom_base.translation.norm(), 10.0 * seconds, 0.2 * seconds);
    EXPECT_NEAR(yaw_of(coasting.T_odom_base.rotation), 0.5 * seconds, 1e-9);
    EXPECT_TRUE(is_valid_covariance(coasting.covariance));
    EXPECT_GT(coasting.covariance.trace(), last_variance);
    last_variance = coasting.covariance.trace();
  }
  EXPECT_GT(std::sqrt(last_variance), 1.5) << "a vehicle that brakes is that far off after 1 s";
}

TEST(Coasting, KeepsWhatIsKnownOfTheDrive) {
  TrackedScan tracked;
  tracked.status.map_points_dropped = 7;
  tracked.status.unobserved_stddev = 0.3;
  tracked.status.elevation_shift = 0.003;
  tracked.status.stamp_jitter = 0.02;
  tracked.status.sweep_times.source = SweepTimes::kNegated;
  tracked.status.gyro_distrusted = true;
  tracked.status.velocity_distrusted = true;
  tracked.status.vertical_ride_distance = 5.0;
  tracked.status.overlap = 0.9;
  const FrontEndStatus status = coasted(tracked, 0.1).status;
  EXPECT_EQ(status.map_points_dropped, 7U);
  EXPECT_EQ(status.unobserved_stddev, 0.3);
  EXPECT_EQ(status.elevation_shift, 0.003);
  EXPECT_EQ(status.stamp_jitter, 0.02);
  EXPECT_EQ(status.sweep_times.source, SweepTimes::kNegated);
  EXPECT_TRUE(status.gyro_distrusted);
  EXPECT_TRUE(status.velocity_distrusted);
  EXPECT_EQ(status.vertical_ride_distance, 5.0);
  EXPECT_EQ(status.overlap, 0.0) << "nothing was matched";
}

// A simulated sensor without noise that stands still sees the same points again and again.
TEST(Coasting, IsNotLostAtRest) {
  TrackedScan tracked;
  tracked.covariance = diagonal_covariance(0.01, 0.001);
  tracked.twist << 0.02, 0.0, 0.01, 0.0, 0.0, 0.005;
  EXPECT_EQ(coasted(tracked, 0.1).status.state, TrackingState::kDegraded);
  tracked.twist << 0.0, 0.0, 0.0, 0.0, 0.0, 0.05;
  EXPECT_EQ(coasted(tracked, 0.1).status.state, TrackingState::kLost);
}

}  // namespace
}  // namespace lidar_mapping::front_end
