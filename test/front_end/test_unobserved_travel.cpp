// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/simulation/random.hpp"

#include "motion/unobserved_travel.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kStep = 0.1;  // s

/// Drives with a speed that changes as at random (0.4 m/s in a second), the first 10 s of each
/// seen, the next 20 s not.
struct Drives {
  double error = 0.0;   ///< root mean square of the way, m
  double stated = 0.0;  ///< the same of what UnobservedTravel reported, m
};

/// `noise` (m/s) is that of a measured speed; 0: none is measured.
Drives drives(double noise) {
  constexpr int kDrives = 300;
  Drives result;
  simulation::Random random(7);
  for (int drive = 0; drive < kDrives; ++drive) {
    UnobservedTravel travel;
    double speed = 10.0;
    const auto go_on = [&] { speed += 0.4 * std::sqrt(kStep) * random.normal(); };
    for (int i = 0; i < 100; ++i) {
      go_on();
      travel.add_observed(speed, 1e-4, kStep);
    }
    double believed = speed;
    double variance = 1e-4;
    double error = 0.0;
    for (int i = 0; i < 200; ++i) {
      go_on();
      variance += 0.016;
      const double information = noise > 0.0 ? 1.0 / (noise * noise) : 0.0;
      const double gain = information / (information + 1.0 / variance);
      if (noise > 0.0) believed += gain * (speed + noise * random.normal() - believed);
      variance = 1.0 / (information + 1.0 / variance);
      error += kStep * (believed - speed);
      travel.add_unobserved(information, kStep);
    }
    result.error += error * error / kDrives;
    result.stated += travel.stddev() * travel.stddev() / kDrives;
  }
  return {std::sqrt(result.error), std::sqrt(result.stated)};
}

TEST(UnobservedTravel, GivesTheErrorOfUnobservedTravel) {
  const Drives unseen = drives(0.0);
  EXPECT_GT(unseen.error, 10.0);
  EXPECT_NEAR(unseen.stated / unseen.error, 1.0, 0.3);
}

TEST(UnobservedTravel, IsReducedByAMeasuredSpeed) {
  const Drives measured = drives(0.1);
  EXPECT_LT(measured.error, 0.3);
  EXPECT_NEAR(measured.stated / measured.error, 1.0, 0.3);
}

TEST(UnobservedTravel, LearnsHowMuchTheSpeedChanges) {
  UnobservedTravel steady;
  UnobservedTravel jerky;
  for (int i = 0; i < 600; ++i) {
    steady.add_observed(5.0, 1e-4, kStep);
    jerky.add_observed(5.0 + (i / 10 % 2), 1e-4, kStep);
  }
  for (int i = 0; i < 100; ++i) {
    steady.add_unobserved(0.0, kStep);
    jerky.add_unobserved(0.0, kStep);
  }
  EXPECT_LT(3.0 * steady.stddev(), jerky.stddev());
}

TEST(UnobservedTravel, AddsOnlyUnobservedSections) {
  UnobservedTravel travel;
  for (int i = 0; i < 50; ++i) travel.add_observed(5.0, 1e-4, kStep);
  EXPECT_EQ(travel.stddev(), 0.0);
  for (int i = 0; i < 50; ++i) travel.add_unobserved(0.0, kStep);
  const double passed = travel.stddev();
  EXPECT_GT(passed, 0.5);
  for (int i = 0; i < 50; ++i) travel.add_observed(5.0, 1e-4, kStep);
  EXPECT_EQ(travel.stddev(), passed) << "what was driven blindly stays as wrong as it is";
}

}  // namespace
}  // namespace lidar_mapping::front_end
