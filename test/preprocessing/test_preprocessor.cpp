// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/cloud_fingerprint.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"

#include "straight_drive.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::append;
using test::at;
using test::drive;
using test::fix;
using test::identity_lookup;
using test::imu;
using test::kNothingMissing;
using test::ring_scan;
using test::velocity;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Preprocessor, DoesNotChangeTheStampOfAScan) {
  Preprocessor stage({}, identity_lookup);
  const auto scans = drive(stage, 3.0, kNothingMissing);
  ASSERT_GE(scans.size(), 28U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Stamp expected = at(0.05 + 0.1 * static_cast<double>(i));
    EXPECT_NEAR(static_cast<double>(scans[i].scan.stamp - expected), 0.0, 1.0);
    ASSERT_TRUE(i == 0 || (scans[i].imu && scans[i].velocity && scans[i].gnss));
    if (!scans[i].gnss) continue;
    EXPECT_EQ(scans[i].imu->stamp, scans[i].scan.stamp);
    EXPECT_EQ(scans[i].velocity->stamp, scans[i].scan.stamp);
    EXPECT_EQ(scans[i].gnss->stamp, scans[i].scan.stamp);
  }
}

/// A ring of points that were measured one after the other, each with an error of its own.
RawScan noisy_scan(Stamp stamp, std::mt19937& engine) {
  std::normal_distribution<float> error(0.0F, 0.02F);
  RawScan scan = ring_scan(stamp);
  for (Point& point : scan.cloud.points) {
    point.z += error(engine);
    scan.cloud.times.push_back(0.001F * static_cast<float>(scan.cloud.times.size()));
  }
  return scan;
}

/// Scans of a driver that hangs from number `frozen` on, in a bend that is ever tighter.
std::vector<SyncedScan> frozen_drive(PreprocessingConfig config, std::size_t frozen) {
  config.use_gnss = false;
  Preprocessor stage(config, identity_lookup);
  std::mt19937 engine(3);
  RawScan raw;
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 200; ++i) {
    const double rate = 2.5e-5 * i * i;
    stage.add_imu(imu(at(0.01 * i), {0.0, 0.0, rate}), "imu");
    stage.add_velocity(velocity(at(0.01 * i), {10.0, 0.0, 0.0}, {0.0, 0.0, rate}), "imu");
    if (i % 10 != 5) continue;
    if (static_cast<std::size_t>(i / 10) <= frozen) raw = noisy_scan(0, engine);
    raw.stamp = at(0.01 * i);
    append(scans, stage.process(raw));
  }
  append(scans, stage.flush());
  return scans;
}

// The points that are handed on differ: each time they are moved by another motion.
TEST(Preprocessor, TellsTheSamePointsOfADriverThatHangs) {
  for (const bool with_velocity : {false, true}) {
    PreprocessingConfig config;
    config.use_velocity = with_velocity;
    const auto scans = frozen_drive(config, 9);
    ASSERT_EQ(scans.size(), 20U);
    for (std::size_t i = 2; i < scans.size(); ++i) {
      ASSERT_TRUE(scans[i].fingerprint);
      EXPECT_EQ(scans[i].fingerprint == scans[i - 1].fingerprint, i > 9) << i;
      EXPECT_NE(cloud_fingerprint(scans[i].scan.cloud), cloud_fingerprint(scans[i - 1].scan.cloud));
    }
  }
}

TEST(Preprocessor, TellsScansOfAStandingSensorApart) {
  Preprocessor stage({}, identity_lookup);
  std::mt19937 engine(3);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 20; ++i) append(scans, stage.process(noisy_scan(at(0.1 * i), engine)));
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 20U);
  for (std::size_t i = 1; i < scans.size(); ++i)
    EXPECT_NE(scans[i].fingerprint, scans[i - 1].fingerprint);
}

TEST(RawScan, HasTheSameFingerprintBeforeItsPointsAreRead) {
  RawScan scan = ring_scan(0), waiting = scan;
  const PointCloud memory = scan.cloud;
  waiting.packed = packed_in(memory);
  waiting.cloud.points.assign(memory.size(), {});
  scan.take_fingerprint();
  waiting.take_fingerprint();
  ASSERT_TRUE(scan.fingerprint);
  EXPECT_EQ(waiting.fingerprint, scan.fingerprint);
}

TEST(Preprocessor, RunsWithEverySubsetOfSensors) {
  for (int subset = 0; subset < 8; ++subset) {
    const auto missing = [&](const std::string& name, double) {
      return (name == "imu" && (subset & 1)) || (name == "velocity" && (subset & 2)) ||
             (name == "gnss" && (subset & 4));
    };
    Preprocessor stage({}, identity_lookup);
    auto scans = drive(stage, 2.0, missing);
    append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 20U) << subset;
    EXPECT_EQ(scans[10].imu.has_value(), !(subset & 1));
    EXPECT_EQ(scans[10].velocity.has_value(), !(subset & 2));
    EXPECT_EQ(scans[10].gnss.has_value(), !(subset & 4));
  }
}

TEST(Preprocessor, ReturnsEveryScanOnceAndInOrder) {
  std::mt19937 engine(5);
  std::vector<int> order(40);
  for (int i = 0; i < 40; ++i) order[i] = i;
  for (std::size_t i = 0; i + 1 < order.size(); i += 2) {
    if (engine() % 2 == 0) std::swap(order[i], order[i + 1]);
  }
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  // 20 scans a second, an IMU that is 150 ms late.
  int samples = 0;
  for (const int i : order) {
    for (; 0.01 * samples < 0.05 * i - 0.15; ++samples) {
      stage.add_imu(imu(at(0.01 * samples)), "imu");
    }
    append(scans, stage.process(ring_scan(at(0.05 * i))));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 40U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].scan.stamp, at(0.05 * static_cast<double>(i)));
  }
}

TEST(Preprocessor, ReportsEachReasonForRejectedFixesOnce) {
  Preprocessor stage({}, identity_lookup);
  for (int i = 0; i < 100; ++i) {
    GnssFix poor = fix(at(0.1 * i));
    poor.covariance = (400.0 + i) * Eigen::Matrix3d::Identity();
    stage.add_gnss(poor, "gps");
    stage.add_gnss(fix(at(0.1 * i + 0.05), 49.0, 8.4, 50001.0 + i), "gps");
  }
  EXPECT_EQ(stage.counters().gnss_refused, 200U);
  EXPECT_EQ(stage.take_diagnostics().size(), 2U);
}

TEST(Preprocessor, StaysFiniteForAnyInput) {
  Preprocessor stage({}, identity_lookup);
  std::vector<SyncedScan> scans;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.01 * i;
    ImuSample bad = imu(at(t));
    if (i % 3 == 0) bad.angular_velocity.y() = kNaN;
    if (i % 5 == 0) bad.orientation = Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0);
    if (i % 7 == 0) bad.orientation = Eigen::Quaterniond(kNaN, 0.0, 0.0, 1.0);
    stage.add_imu(bad, "imu");
    stage.add_imu(bad, "imu");
    stage.add_velocity(velocity(at(t), {i % 4 == 0 ? kNaN : 1.0, 0.0, 0.0}), "imu");
    stage.add_gnss(fix(at(t), i % 2 == 0 ? kNaN : 49.0), "gps");
    if (i % 10 == 5) append(scans, stage.process(ring_scan(at(t))));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 20U);
  EXPECT_GT(stage.counters().samples_refused, 200U);
  for (const SyncedScan& scan : scans) {
    if (scan.imu) {
      EXPECT_TRUE(scan.imu->angular_velocity.allFinite());
      EXPECT_FALSE(scan.imu->orientation.has_value());
    }
    if (scan.velocity) {
      EXPECT_TRUE(scan.velocity->linear.allFinite());
    }
    if (scan.gnss) {
      EXPECT_TRUE(scan.gnss->p_enu_antenna.allFinite());
    }
    for (const Point& point : scan.scan.cloud.points) EXPECT_TRUE(point.position().allFinite());
  }
}

TEST(Preprocessor, DropsAndReportsScansWithoutPoints) {
  Preprocessor stage({}, identity_lookup);
  RawScan empty{at(0.0), "lidar", {}};
  RawScan nan = ring_scan(at(0.1));
  for (Point& p : nan.cloud.points) p.x = std::numeric_limits<float>::quiet_NaN();
  RawScan few = ring_scan(at(0.2), 10);
  RawScan far = ring_scan(at(0.3));
  for (Point& p : far.cloud.points) p.x = 1000.0F;
  for (const RawScan& scan : {empty, nan, few, far}) EXPECT_TRUE(stage.process(scan).empty());
  EXPECT_TRUE(stage.flush().empty());
  EXPECT_EQ(stage.counters().scans_without_points, 4U);
  EXPECT_EQ(stage.counters().points_not_finite, 100U);
  EXPECT_FALSE(stage.take_diagnostics().empty());
}

TEST(Preprocessor, RejectsAContradictoryConfiguration) {
  const auto& checks = PreprocessingConfig::schema().checks();
  const auto problem = [&](const PreprocessingConfig& config) {
    std::string all;
    for (const auto& check : checks) all += check(config);
    return all;
  };
  EXPECT_EQ(problem({}), "");
  PreprocessingConfig config;
  config.distance_near_thresh = 300.0;
  EXPECT_NE(problem(config), "");
  config = {};
  config.vehicle_box = {1, 0, 0, 0, 0, 0};
  EXPECT_NE(problem(config), "");
  config = {};
  config.use_datum = true;
  config.datum = {120.0, 0.0, 0.0};
  EXPECT_NE(problem(config), "");
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
