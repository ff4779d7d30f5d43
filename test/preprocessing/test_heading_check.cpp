// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "checks/heading_check.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr double kStep = 6.0;  // m; a section has five or more

/// A vehicle whose positions are known to `sigma` (m).
class Drive {
 public:
  explicit Drive(double yaw, double sigma = 0.02) : sigma_(sigma) { add(yaw, false); }

  /// Drives a step straight in direction `course`; at its end the IMU has the heading `yaw`.
  void step(double course, double yaw, bool backwards = false) {
    p_enu_ += kStep * Eigen::Vector3d(std::cos(course), std::sin(course), 0.0);
    add(yaw, backwards);
  }

  std::optional<bool> agrees() const { return check_.agrees(); }

 private:
  void add(double yaw, bool backwards) {
    check_.add(p_enu_, sigma_, exp_so3({0.0, 0.0, yaw}), backwards);
  }

  HeadingCheck check_;
  Eigen::Vector3d p_enu_ = Eigen::Vector3d::Zero();
  double sigma_;
};

TEST(HeadingCheck, AgreesAfterThreeSections) {
  Drive drive(0.5);
  drive.step(0.5, 0.5);
  drive.step(0.5, 0.5);
  EXPECT_FALSE(drive.agrees().has_value());
  drive.step(0.5, 0.5);
  EXPECT_EQ(drive.agrees(), true);
}

TEST(HeadingCheck, ContradictsAfterThreeSections) {
  Drive drive(0.0);
  drive.step(0.6, 0.0);
  drive.step(0.6, 0.0);
  EXPECT_FALSE(drive.agrees().has_value());
  drive.step(0.6, 0.0);
  EXPECT_EQ(drive.agrees(), false);
}

TEST(HeadingCheck, DecidesNothingBetweenFifteenAndThirtyDegrees) {
  for (const double error : {16.0, 29.0, -16.0, -29.0}) {
    Drive drive(0.0);
    for (int i = 0; i < 10; ++i) drive.step(error * kRadPerDeg, 0.0);
    EXPECT_FALSE(drive.agrees().has_value()) << error;
  }
}

TEST(HeadingCheck, NeedsThreeSectionsInARow) {
  Drive drive(0.0);
  for (int round = 0; round < 3; ++round) {
    drive.step(0.0, 0.0);
    drive.step(0.0, 0.0);
    drive.step(20.0 * kRadPerDeg, 0.0);  // undecided
    drive.step(1.0, 0.0);
    drive.step(1.0, 0.0);
  }
  EXPECT_FALSE(drive.agrees().has_value());
}

TEST(HeadingCheck, CanReverseItsDecision) {
  Drive drive(0.0);
  for (int i = 0; i < 3; ++i) drive.step(1.0, 0.0);
  EXPECT_EQ(drive.agrees(), false);
  for (int i = 0; i < 2; ++i) drive.step(0.0, 0.0);
  EXPECT_EQ(drive.agrees(), false);
  drive.step(0.0, 0.0);
  EXPECT_EQ(drive.agrees(), true);
}

TEST(HeadingCheck, TurnsTheHeadingOfAVehicleThatDrivesBackwards) {
  HeadingCheck check;
  for (int i = 0; i < 4; ++i) {
    check.add({-kStep * i, 0.0, 0.0}, 0.02, Eigen::Quaterniond::Identity(), true);
  }
  EXPECT_EQ(check.agrees(), true);
}

TEST(HeadingCheck, ComparesAcrossHalfATurn) {
  Drive drive(kPi - 0.05);
  for (int i = 0; i < 3; ++i) drive.step(kPi, i % 2 == 0 ? -kPi + 0.05 : kPi - 0.05);
  EXPECT_EQ(drive.agrees(), true);
}

// A section ends at eight standard deviations of a position: here with every second step.
TEST(HeadingCheck, TakesLongerSectionsOfPoorFixes) {
  Drive drive(0.0, 1.0);
  for (int i = 0; i < 5; ++i) drive.step(0.0, 0.0);
  EXPECT_FALSE(drive.agrees().has_value());
  drive.step(0.0, 0.0);
  EXPECT_EQ(drive.agrees(), true);
}

TEST(HeadingCheck, DoesNotCompareAcrossASharpTurn) {
  Drive drive(0.0);
  for (int i = 1; i <= 20; ++i) drive.step(0.4 * (i - 0.5), 0.4 * i);
  EXPECT_FALSE(drive.agrees().has_value());
}

// The IMU errs by 0.2 rad (11 degrees), which agrees; beside the heading at the beginning of a
// section the course would differ by 0.37 rad (21 degrees).
TEST(HeadingCheck, ComparesWithTheHeadingInTheMiddleOfASection) {
  constexpr double kTurn = 0.34, kError = -0.2;  // rad
  Drive drive(kError);
  for (int i = 1; i <= 3; ++i) drive.step(kTurn * (i - 0.5), kTurn * i + kError);
  EXPECT_EQ(drive.agrees(), true);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
