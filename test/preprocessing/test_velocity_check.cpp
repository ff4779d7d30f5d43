// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "straight_drive.hpp"

// Velocities in another unit or in the axes of the map are not used.
namespace lidar_mapping::preprocessing {
namespace {

using test::append;
using test::at;
using test::fix;
using test::identity_lookup;
using test::imu;
using test::ring_scan;
using test::velocity;

constexpr double kSpeed = 8.0;  // m/s

/// Heading east at 8 m/s for five seconds, then in a circle to the left.
struct Course {
  double turning(double t) const { return t < 5.0 ? 0.0 : 0.4; }
  double heading(double t) const { return t < 5.0 ? 0.0 : 0.4 * (t - 5.0); }
  Eigen::Vector2d position(double t) const {
    if (t < 5.0) return {kSpeed * t, 0.0};
    const double radius = kSpeed / 0.4;
    return {kSpeed * 5.0 + radius * std::sin(heading(t)), radius * (1.0 - std::cos(heading(t)))};
  }
};

/// What the velocity's driver sends at t.
using Sender = std::function<Eigen::Vector3d(double t)>;

struct Outcome {
  std::vector<SyncedScan> scans;  ///< one in 0.1 s
  std::string diagnostics;
};

enum class Fixes { kNone, kGood, kScattered };

Outcome driven(const Sender& sent, Fixes fixes = Fixes::kGood) {
  const Course course;
  Preprocessor stage({}, identity_lookup);
  Outcome outcome;
  for (int tick = 0; tick < 2000; ++tick) {
    const double t = 0.01 * tick;
    stage.add_imu(imu(at(t), {0.0, 0.0, course.turning(t)}), "imu");
    if (tick % 2 == 0) stage.add_velocity(velocity(at(t), sent(t)), "imu");
    Eigen::Vector2d p = course.position(t);
    if (fixes == Fixes::kScattered) p.y() += (tick / 10) % 3 == 0 ? 6.0 : -3.0;
    if (fixes != Fixes::kNone && tick % 10 == 0) {
      stage.add_gnss(fix(at(t), 49.0 + p.y() / 111211.0, 8.4 + p.x() / 73172.0), "gps");
    }
    if (tick % 10 != 5) continue;
    RawScan scan = ring_scan(at(t));
    for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
      scan.cloud.times.push_back(0.1F * static_cast<float>(i) / 100.0F);
    }
    append(outcome.scans, stage.process(std::move(scan)));
  }
  append(outcome.scans, stage.flush());
  outcome.diagnostics = test::messages_of(stage);
  return outcome;
}

Eigen::Vector3d ahead(double) { return {kSpeed, 0.0, 0.0}; }
Eigen::Vector3d in_enu(double t) {
  const double heading = Course().heading(t);
  return {kSpeed * std::cos(heading), kSpeed * std::sin(heading), 0.0};
}

bool uses_velocity(const SyncedScan& scan) {
  // Compensated scans keep no times.
  EXPECT_EQ(scan.velocity.has_value(), !scan.scan.cloud.has_times());
  return scan.velocity.has_value();
}

TEST(VelocityCheck, AVelocityThatAgreesIsUsed) {
  const Outcome outcome = driven(ahead);
  ASSERT_EQ(outcome.scans.size(), 200U);
  for (std::size_t i = 0; i < 199; ++i) EXPECT_TRUE(uses_velocity(outcome.scans[i])) << i;
  EXPECT_EQ(outcome.diagnostics.find("velocity:"), std::string::npos) << outcome.diagnostics;
}

TEST(VelocityCheck, KilometresPerHourAreReportedAndNotUsed) {
  const Outcome outcome =
      driven([](double t) -> Eigen::Vector3d { return (t < 12.0 ? 3.6 : 1.0) * ahead(t); });
  ASSERT_EQ(outcome.scans.size(), 200U);
  EXPECT_FALSE(uses_velocity(outcome.scans[50]));
  EXPECT_FALSE(uses_velocity(outcome.scans[110]));
  EXPECT_TRUE(uses_velocity(outcome.scans[180]));
  EXPECT_NE(outcome.diagnostics.find("3.60 times those of the fixes: they are in km/h"),
            std::string::npos)
      << outcome.diagnostics;
  EXPECT_TRUE(outcome.scans[60].gnss);  // the fixes are not held against it
}

/// Scattered by metres, whatever their covariance says.
TEST(VelocityCheck, BadFixesDoNotChangeTheUnit) {
  const Outcome outcome = driven(ahead, Fixes::kScattered);
  ASSERT_EQ(outcome.scans.size(), 200U);
  for (const SyncedScan& scan : outcome.scans) EXPECT_TRUE(scan.velocity);
}

TEST(VelocityCheck, AVelocityInEastNorthUpIsReportedAndNotUsed) {
  for (const Fixes fixes : {Fixes::kGood, Fixes::kNone}) {
    const Outcome outcome = driven(in_enu, fixes);
    ASSERT_EQ(outcome.scans.size(), 200U);
    EXPECT_TRUE(uses_velocity(outcome.scans[40]));  // nothing tells yet
    for (std::size_t i = 95; i < 200; ++i) EXPECT_FALSE(uses_velocity(outcome.scans[i])) << i;
    EXPECT_NE(outcome.diagnostics.find("velocity:"), std::string::npos) << outcome.diagnostics;
  }
}

TEST(VelocityCheck, ASidewaysVelocityIsUsedAfterATurn) {
  const Outcome sideways =
      driven([](double) { return Eigen::Vector3d(0.0, kSpeed, 0.0); }, Fixes::kNone);
  ASSERT_EQ(sideways.scans.size(), 200U);
  EXPECT_FALSE(uses_velocity(sideways.scans[40]));
  EXPECT_TRUE(uses_velocity(sideways.scans[180]));
  EXPECT_NE(sideways.diagnostics.find("points aside"), std::string::npos) << sideways.diagnostics;
}

/// What flies may yaw on a straight way.
TEST(VelocityCheck, AVelocityThatTurnsAgainstTheVehicleIsInItsAxes) {
  const Outcome outcome = driven(
      [](double t) -> Eigen::Vector3d {
        const double heading = Course().heading(t);
        return {kSpeed * std::cos(heading), -kSpeed * std::sin(heading), 0.0};
      },
      Fixes::kNone);
  ASSERT_EQ(outcome.scans.size(), 200U);
  EXPECT_TRUE(uses_velocity(outcome.scans[190]));
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
