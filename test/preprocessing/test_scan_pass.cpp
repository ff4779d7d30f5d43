// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "points/thinning.hpp"
#include "samples.hpp"
#include "test_data.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

PointCloud random_cloud(std::uint32_t seed, std::size_t count, float extent) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> axis(-extent, extent);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.push_back({axis(engine), axis(engine), axis(engine), static_cast<float>(i)});
    cloud.times.push_back(1e-4F * static_cast<float>(i % 1000));
  }
  return cloud;
}

TEST(ScanPass, CutsByRangeFromTheSensor) {
  PreprocessingConfig config;
  config.distance_near_thresh = 2.0;
  config.distance_far_thresh = 20.0;
  const Pose T_base_lidar{exp_so3({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0}};
  PointCloud cloud = random_cloud(1, 5000, 25.0F);
  const PointCloud raw = cloud;
  keep_and_deskew(packed_in(cloud), cloud, T_base_lidar, PassLimits(config), nullptr);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const float range = raw.points[i].position().norm();
    if (range < 2.0F || range > 20.0F) continue;
    ASSERT_LT(kept, cloud.size());
    EXPECT_EQ(cloud.points[kept].position(), raw.points[i].position());
    EXPECT_EQ(cloud.points[kept].intensity, raw.points[i].intensity);
    EXPECT_EQ(cloud.times[kept], raw.times[i]);
    ++kept;
  }
  EXPECT_EQ(cloud.size(), kept);
}

TEST(ScanPass, KeepsAllPointsWithTheFilterOff) {
  PreprocessingConfig config;
  config.use_distance_filter = false;
  PointCloud cloud = random_cloud(2, 1000, 500.0F);
  keep_and_deskew(packed_in(cloud), cloud, Pose::Identity(), PassLimits(config), nullptr);
  EXPECT_EQ(cloud.size(), 1000U);
}

TEST(ScanPass, DropsInvalidPoints) {
  PointCloud cloud;
  cloud.points = {
      {kNaN, 1, 1, 0}, {0, 0, 0, 0},     {std::numeric_limits<float>::infinity(), 0, 0, 0},
      {5, 0, 0, 3},    {1e30F, 0, 0, 0}, {5, 1, 0, 4}};
  cloud.times = {0, 0, 0, 0, 0, kNaN};
  EXPECT_EQ(keep_and_deskew(packed_in(cloud), cloud, Pose::Identity(), PassLimits({}), nullptr),
            4U);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.points[0].intensity, 3.0F);
}

TEST(ScanPass, AcceptsAnEmptyScan) {
  PointCloud cloud;
  EXPECT_EQ(keep_and_deskew(packed_in(cloud), cloud, Pose::Identity(), PassLimits({}), nullptr),
            0U);
  EXPECT_TRUE(cloud.empty());
}

TEST(ScanPass, RemovesTheVehicle) {
  PreprocessingConfig config;
  config.vehicle_box = {-2.0, -1.0, 0.0, 3.0, 1.0, 2.0};
  PointCloud cloud;
  cloud.points = {{0, 0, -1, 1}, {4, 0, 0, 2}, {1, 0.5F, -1.5F, 3}};
  // The sensor sits 2 m above base_link.
  keep_and_deskew(packed_in(cloud), cloud, Pose{Eigen::Quaterniond::Identity(), {0, 0, 2}},
                  PassLimits(config), nullptr);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.points[0].intensity, 2.0F);
}

// Motion compensation carries what rides along out of the box, and a thing beside it into it.
TEST(ScanPass, RemovesTheVehicleWhereItWasMeasured) {
  PreprocessingConfig config;
  config.vehicle_box = {-2.0, -1.0, 0.0, 3.0, 1.0, 2.0};
  const auto straight = [](double) { return Eigen::Vector3d::Zero().eval(); };
  const auto fast = [](double, const Eigen::Vector3d&) { return Eigen::Vector3d(11.0, 0.0, 0.0); };
  const ScanMotion motion = *integrated(0.0, 0.1, straight, fast);
  PointCloud cloud;
  cloud.points = {{2.9F, 0, -1, 1}, {2.9F, 0, -1, 2}, {-2.5F, 0, -1, 3}, {-2.5F, 0, -1, 4}};
  cloud.times = {0.0F, 0.1F, 0.0F, 0.1F};
  keep_and_deskew(packed_in(cloud), cloud, Pose{Eigen::Quaterniond::Identity(), {0, 0, 2}},
                  PassLimits(config), &motion);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(cloud.points[0].intensity, 3.0F);
  EXPECT_EQ(cloud.points[1].intensity, 4.0F);
  EXPECT_NEAR(cloud.points[1].x, -1.4F, 1e-3);
}

TEST(ScanPass, RemovesTheVehicleForAnySensorPose) {
  PreprocessingConfig config;
  config.vehicle_box = {-2.0, -1.0, 0.0, 3.0, 1.0, 2.0};
  // Its x points to the left of base_link and its z ahead.
  const Eigen::Quaterniond R_base_sensor(
      (Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished());
  const Pose T_base_sensor{R_base_sensor, {1.0, 0.0, 2.0}};
  const Pose T_sensor_base = T_base_sensor.inverse();
  PointCloud cloud;
  for (const Eigen::Vector3d& p_base :
       {Eigen::Vector3d(2.9, 0.9, 0.1), Eigen::Vector3d(3.1, 0.9, 0.1),
        Eigen::Vector3d(-1.9, -0.9, 1.9), Eigen::Vector3d(-1.9, -1.1, 1.9)}) {
    const Eigen::Vector3f p = (T_sensor_base * p_base).cast<float>();
    cloud.points.push_back({p.x(), p.y(), p.z(), static_cast<float>(cloud.size())});
  }
  const PointCloud raw = cloud;
  keep_and_deskew(packed_in(cloud), cloud, T_base_sensor, PassLimits(config), nullptr);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(cloud.points[0].position(), raw.points[1].position());
  EXPECT_EQ(cloud.points[1].position(), raw.points[3].position());
}

TEST(ScanTimes, FollowTheAzimuthInBothDirections) {
  for (const ScanDirection direction :
       {ScanDirection::kClockwise, ScanDirection::kCounterclockwise}) {
    for (const double start_deg : {0.0, 90.0, 180.0, -135.0}) {
      PreprocessingConfig config;
      config.point_times = PointTimes::kAzimuth;
      config.scan_direction = direction;
      config.scan_start_azimuth = start_deg * kRadPerDeg;
      PointCloud cloud;
      for (int i = 0; i < 360; ++i) {
        const double sign = direction == ScanDirection::kClockwise ? -1.0 : 1.0;
        const double azimuth = config.scan_start_azimuth + sign * 2.0 * M_PI * (i + 0.5) / 360.0;
        cloud.points.push_back({static_cast<float>(10.0 * std::cos(azimuth)),
                                static_cast<float>(10.0 * std::sin(azimuth)), 0.0F, 0.0F});
      }
      EXPECT_EQ(normalize_times(cloud, false, config).problem, "");
      for (int i = 0; i < 360; ++i) {
        EXPECT_NEAR(cloud.times[i], 0.1 * (i + 0.5) / 360.0, 1e-6);
      }
    }
  }
}

TEST(ScanTimes, ReferToTheInstantOfTheStamp) {
  for (const auto& [meaning, shift] :
       {std::pair{ScanStamp::kStart, 0.0}, std::pair{ScanStamp::kMiddle, 0.05},
        std::pair{ScanStamp::kEnd, 0.1}}) {
    PreprocessingConfig config;
    config.scan_stamp = meaning;
    PointCloud from_start, to_end, absolute;
    from_start.points.resize(3, {5, 0, 0, 0});
    to_end = absolute = from_start;
    from_start.times = {0.0F, 0.05F, 0.1F};
    to_end.times = {-0.1F, -0.05F, 0.0F};
    absolute.times = {0.0F, 0.05F, 0.1F};
    normalize_times(from_start, false, config);
    normalize_times(to_end, false, config);
    normalize_times(absolute, true, config);
    EXPECT_NEAR(from_start.times[0], -shift, 1e-7);
    EXPECT_NEAR(to_end.times[0], -0.1, 1e-7);
    EXPECT_NEAR(absolute.times[2], 0.1, 1e-7);
  }
}

TEST(ScanTimes, OfAWrongUnitAreRejectedWithAMessage) {
  for (const float factor : {1e3F, 1e6F, 1e9F}) {
    PointCloud cloud;
    cloud.points.resize(2, {5, 0, 0, 0});
    cloud.times = {0.0F, 0.1F * factor};
    EXPECT_NE(normalize_times(cloud, false, {}).problem, "");
    EXPECT_FALSE(cloud.has_times());
  }
}

TEST(Thinning, FiltersCloudsOfAnyExtent) {
  for (const DownsampleMethod method :
       {DownsampleMethod::kVoxelGrid, DownsampleMethod::kApproximateVoxelGrid}) {
    PreprocessingConfig config;
    config.downsample_method = method;
    config.downsample_resolution = 0.5;
    PointCloud cloud = random_cloud(4, 20000, 2.0F);
    cloud.points.push_back({100000.0F, 0.0F, 0.0F, 0.0F});
    cloud.times.push_back(0.0F);
    const PointCloud thin = downsampled(cloud, config);
    EXPECT_LE(thin.size(), 9U * 9U * 9U + 1U);
    EXPECT_GT(thin.size(), 400U);
    EXPECT_EQ(thin.times.size(), thin.size());
  }
  EXPECT_EQ(downsampled(random_cloud(5, 100, 2.0F), {}).size(), 100U);
}

TEST(Thinning, RemovesIsolatedPointsAndKeepsTimes) {
  PointCloud cloud = random_cloud(6, 4000, 3.0F);
  cloud.points.push_back({50.0F, 50.0F, 50.0F, -1.0F});
  cloud.times.push_back(0.077F);
  for (const OutlierRemovalMethod method :
       {OutlierRemovalMethod::kStatistical, OutlierRemovalMethod::kRadius}) {
    PreprocessingConfig config;
    config.outlier_removal_method = method;
    const PointCloud clean = without_outliers(cloud, config);
    EXPECT_GT(clean.size(), 3000U);
    ASSERT_EQ(clean.times.size(), clean.size());
    for (std::size_t i = 0; i < clean.size(); ++i) {
      EXPECT_GE(clean.points[i].intensity, 0.0F);
      const auto original = static_cast<std::size_t>(clean.points[i].intensity);
      EXPECT_EQ(clean.times[i], cloud.times[original]);
    }
  }
  EXPECT_EQ(without_outliers(cloud, {}).size(), cloud.size());
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
