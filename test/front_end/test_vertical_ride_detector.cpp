// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "motion/vertical_ride_detector.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kPeriod = 0.1;  // s, of the scans
constexpr double kGravity = 9.81;

using Acceleration = std::function<double(double time)>;

double none(double /*time*/) { return 0.0; }

/// A lift that starts after 10 s, goes at 1.5 m/s and stops after 18 s.
double lift(double t) {
  if (t > 10.0 && t < 11.5) return 1.0;
  return t > 16.5 && t < 18.0 ? -1.0 : 0.0;
}

/// Carried by a person: the gait is seen and felt, the lift only felt.
struct Walk {
  double tilt = 0.2;  // rad
  Eigen::Vector3d bias{0.2, -0.3, 0.25};
  Acceleration unseen = none;
  double seen_error = 0.005;  // m
};

struct Outcome {
  double first = -1.0;  ///< s when a ride was reported first
  double last = -1.0;
  double way = 0.0;
};

Outcome taken(const Walk& walk, double seconds) {
  constexpr int kParts = 20;
  const Eigen::Vector3d p_base_imu(0.1, -0.05, 0.2);
  const auto pose = [&](double t) {
    Pose T;
    T.rotation = exp_so3({walk.tilt * std::sin(0.7 * t), walk.tilt * std::cos(0.5 * t), 0.4 * t});
    T.translation = {1.2 * t, 0.1 * std::sin(6.0 * t), 0.03 * std::sin(12.0 * t)};
    return T;
  };
  const auto place = [&](double t) { return Eigen::Vector3d(pose(t) * p_base_imu); };
  VerticalRideDetector ride;
  Outcome outcome;
  for (int i = 0; i * kPeriod < seconds; ++i) {
    const double t = i * kPeriod;
    FeltForce force;
    force.p_base_imu = p_base_imu;
    for (int k = 0; k < kParts; ++k) {
      const double s = t - kPeriod * (k + 0.5) / kParts;
      constexpr double kStep = 1e-3;
      const Eigen::Vector3d seen =
          (place(s + kStep) - 2.0 * place(s) + place(s - kStep)) / (kStep * kStep);
      const Eigen::Vector3d felt = seen + Eigen::Vector3d(0.0, 0.0, kGravity + walk.unseen(s));
      force.mean += (pose(s).rotation.conjugate() * felt + walk.bias) / kParts;
    }
    Pose T = pose(t);
    T.translation.z() += walk.seen_error * std::sin(37.0 * i);
    ride.add(T, kPeriod, i > 0 ? std::optional<FeltForce>(force) : std::nullopt);
    if (ride.is_riding()) {
      if (outcome.first < 0.0) outcome.first = t;
      outcome.last = t;
    }
  }
  outcome.way = ride.distance();
  return outcome;
}

// Nothing in the view of a lift's car tells that it goes up.
TEST(VerticalRideDetector, DetectsARideFromStartToStop) {
  Walk walk;
  walk.unseen = lift;
  const Outcome outcome = taken(walk, 30.0);
  EXPECT_GT(outcome.first, 10.0);
  EXPECT_LT(outcome.first, 13.0);
  EXPECT_GT(outcome.last, 18.0);
  EXPECT_LT(outcome.last, 22.0);
  EXPECT_NEAR(outcome.way, 9.7, 3.0);
}

TEST(VerticalRideDetector, IgnoresAWalk) {
  for (const double tilt : {0.0, 0.2, 0.5}) {
    Walk walk;
    walk.tilt = tilt;
    EXPECT_EQ(taken(walk, 60.0).way, 0.0) << tilt;
  }
}

// Errors of the odometry look like unseen motion. How large they are is learned, and only a larger
// difference counts.
TEST(VerticalRideDetector, IgnoresScatteringHeights) {
  Walk walk;
  walk.seen_error = 0.06;
  EXPECT_EQ(taken(walk, 60.0).way, 0.0);
}

// A recording that is paused in a lift: the ride ends while nothing is recorded.
TEST(VerticalRideDetector, RidesForNoLongerThanAMinuteOverAGap) {
  for (const bool interrupted : {false, true}) {
    VerticalRideDetector ride;
    FeltForce force;
    for (int i = 0; i < 135; ++i) {
      force.mean = {0.0, 0.0, kGravity + lift(kPeriod * i)};
      ride.add(Pose{}, kPeriod, i > 0 ? std::optional<FeltForce>(force) : std::nullopt);
    }
    ASSERT_TRUE(ride.is_riding());
    const double before = ride.distance();
    ASSERT_GT(before, 0.5);
    if (interrupted) ride.interrupt();
    ride.add(Pose{}, 600.0, std::nullopt);
    EXPECT_FALSE(ride.is_riding());
    EXPECT_LT(ride.distance() - before, 60.0 * 2.0) << "900 m at 1.5 m/s";
  }
}

TEST(VerticalRideDetector, NeedsAnAccelerometer) {
  VerticalRideDetector ride;
  for (int i = 0; i < 100; ++i) {
    Pose pose;
    pose.translation.z() = 0.02 * i * i;
    ride.add(pose, kPeriod, std::nullopt);
  }
  EXPECT_FALSE(ride.is_riding());
  EXPECT_EQ(ride.distance(), 0.0);
}

}  // namespace
}  // namespace lidar_mapping::front_end
