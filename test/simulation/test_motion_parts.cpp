// SPDX-License-Identifier: BSD-3-Clause
// Of what motions are composed: smoothing, stations over time, walking, standing and turning.

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "motion/smoothing.hpp"
#include "motion/track.hpp"
#include "motion/vehicle_motion.hpp"
#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

using test::near;

TEST(SmoothStep, GoesFromZeroToOneAndRestsAtBothEnds) {
  EXPECT_EQ(smooth_step(-1.0), 0.0);
  EXPECT_EQ(smooth_step(0.0), 0.0);
  EXPECT_DOUBLE_EQ(smooth_step(0.5), 0.5);
  EXPECT_DOUBLE_EQ(smooth_step(1.0), 1.0);
  EXPECT_DOUBLE_EQ(smooth_step(7.0), 1.0);
  constexpr double kStep = 1e-4;
  for (const double end : {0.0, 1.0}) {
    const double a = smooth_step(end - kStep), b = smooth_step(end), c = smooth_step(end + kStep);
    EXPECT_NEAR((c - a) / (2.0 * kStep), 0.0, 1e-6) << "the speed at " << end;
    EXPECT_NEAR((a - 2.0 * b + c) / (kStep * kStep), 0.0, 1e-2) << "the acceleration at " << end;
  }
}

TEST(Smoothed, AveragesOverItsWindow) {
  std::vector<double> values(11, 0.0);
  values[5] = 5.0;
  const std::vector<double> once = smoothed(values, 2, 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(once[i], i >= 3 && i <= 7 ? 1.0 : 0.0, 1e-12) << i;
  }
  const std::vector<double> twice = smoothed(values, 2, 2);
  EXPECT_NEAR(twice[5], 1.0, 1e-12);
  EXPECT_NEAR(twice[4], 0.8, 1e-12);
  EXPECT_EQ(smoothed(values, 2, 0), values);
}

TEST(Smoothed, KeepsEndsAndStraightLines) {
  std::vector<double> line, wavy;
  for (int i = 0; i < 30; ++i) {
    line.push_back(2.0 - 0.3 * i);
    wavy.push_back(std::sin(0.7 * i) + 1.0);
  }
  const std::vector<double> same = smoothed(line, 4, 3);
  for (std::size_t i = 0; i < line.size(); ++i) EXPECT_NEAR(same[i], line[i], 1e-12) << i;
  const std::vector<double> smooth = smoothed(wavy, 4, 3);
  EXPECT_NEAR(smooth.front(), wavy.front(), 1e-12);
  EXPECT_NEAR(smooth.back(), wavy.back(), 1e-12);
}

Path straight(double metres) { return Path::rounded({{0.0, 0.0}, {metres, 0.0}}, 1.0); }

/// Speeds from the stations, m/s.
std::vector<double> speeds_of(const std::vector<double>& stations, double step) {
  std::vector<double> speeds;
  for (std::size_t i = 1; i < stations.size(); ++i) {
    speeds.push_back((stations[i] - stations[i - 1]) / step);
  }
  return speeds;
}

double greatest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

double least(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

// To 10 m/s and back in 25 m each with 2 m/s^2, which takes 5 s each, and 50 m between; with three
// and two seconds of rest.
TEST(StationsOverTime, KeepWithinTheLimits) {
  constexpr double kStep = 0.02;
  const SpeedLimits limits{10.0, 2.4, 2.0};
  const std::vector<double> stations =
      stations_over_time(straight(120.0), 10.0, 110.0, limits, {}, kStep);
  EXPECT_NEAR(kStep * static_cast<double>(stations.size()), 3.0 + 5.0 + 5.0 + 5.0 + 2.0, 0.1);
  EXPECT_NEAR(stations.front(), 10.0, 1e-9);
  EXPECT_NEAR(stations[100], 10.0, 1e-3) << "at rest for two seconds and more";
  EXPECT_NEAR(stations.back(), 110.0, 0.11);
  const std::vector<double> speeds = speeds_of(stations, kStep);
  EXPECT_NEAR(greatest(speeds), 10.0, 0.01);
  EXPECT_GE(least(speeds), -1e-9);
  const std::vector<double> accelerations = speeds_of(speeds, kStep);
  EXPECT_NEAR(greatest(accelerations), 2.0, 0.05);
  EXPECT_NEAR(least(accelerations), -2.0, 0.05);
}

TEST(StationsOverTime, HaltWhereTheyShall) {
  constexpr double kStep = 0.02;
  const SpeedLimits limits{10.0, 2.4, 2.0};
  const std::vector<double> on = stations_over_time(straight(120.0), 0.0, 100.0, limits, {}, kStep);
  const std::vector<double> halting =
      stations_over_time(straight(120.0), 0.0, 100.0, limits, {{50.0, 6.0}}, kStep);
  const auto at_rest = std::count_if(halting.begin(), halting.end(),
                                     [](double s) { return std::abs(s - 50.0) < 0.11; });
  EXPECT_GT(kStep * static_cast<double>(at_rest), 5.5);
  EXPECT_LT(kStep * static_cast<double>(at_rest), 8.0);
  // Besides the halt it needs 5 m/s times 5 s twice instead of 50 m at 10 m/s: 5 s more.
  EXPECT_NEAR(kStep * static_cast<double>(halting.size() - on.size()), 6.0 + 5.0, 0.3);
}

TEST(StationsOverTime, SlowDownInABend) {
  constexpr double kStep = 0.02, kRadius = 10.0;
  const SpeedLimits limits{12.0, 2.5, 3.0};
  const Path bend = Path::rounded({{0.0, 0.0}, {60.0, 0.0}, {60.0, 60.0}}, kRadius, 0.5);
  const std::vector<double> stations =
      stations_over_time(bend, 0.0, bend.length(), limits, {}, kStep);
  const std::vector<double> speeds = speeds_of(stations, kStep);
  const double middle = 50.0 + 0.25 * kPi * kRadius;  // of the arc, which begins at 50 m
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    if (std::abs(stations[i] - middle) > 4.0) continue;
    EXPECT_NEAR(speeds[i], std::sqrt(2.5 * kRadius), 0.35) << stations[i];
  }
  EXPECT_GT(greatest(speeds), 9.0);
}

TEST(Track, StandsAndTurnsOnTheSpot) {
  Track track({1.0, 2.0}, 0.5);
  track.stand(2.0);
  EXPECT_EQ(track.states().size(), 401U);
  EXPECT_NEAR(track.states().back().yaw, 0.5, 1e-12);
  track.turn(-1.2, 0.6);
  const std::vector<TrackState>& states = track.states();
  EXPECT_NEAR(states.back().yaw, -0.7, 1e-12);
  EXPECT_EQ(states.back().distance, 0.0);
  EXPECT_TRUE(near(states.back().position, Eigen::Vector2d(1.0, 2.0), 1e-12));
  double fastest = 0.0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    fastest = std::max(fastest, std::abs(states[i].yaw - states[i - 1].yaw) / Track::kStep);
  }
  EXPECT_NEAR(fastest, 0.6, 0.005);
  EXPECT_NEAR(track.seconds(), 2.0 + 1.2 / 0.6 * 15.0 / 8.0, 0.02);
}

TEST(Track, TurnsInTheShorterDirectionToItsPathAndWalksIt) {
  Track track({0.0, 0.0}, 3.0);
  track.walk({{0.0, -8.0}}, {1.2, 0.5, 0.6});
  const std::vector<TrackState>& states = track.states();
  EXPECT_NEAR(states.back().yaw, 1.5 * kPi, 1e-6) << "unwrapped: 1.7 rad to the left";
  EXPECT_TRUE(near(states.back().position, Eigen::Vector2d(0.0, -8.0), 0.3));
  EXPECT_NEAR(states.back().distance, 8.0, 0.3);
  for (std::size_t i = 1; i < states.size(); ++i) {
    const double step = (states[i].position - states[i - 1].position).norm();
    ASSERT_LT(step, 1.25 * Track::kStep) << i;
    ASSERT_NEAR(states[i].distance - states[i - 1].distance, step, 1e-6) << i;
  }
}

TEST(Track, GoesOnFromWhereItStands) {
  Track track({0.0, 0.0}, 0.0);
  track.walk({{5.0, 0.0}}, {1.2, 0.5, 0.6});
  const TrackState before = track.states().back();
  track.walk({{5.0, 5.0}}, {1.2, 0.5, 0.6});
  const TrackState& after = track.states().back();
  EXPECT_NEAR(after.yaw, 0.5 * kPi, 0.07);
  EXPECT_NEAR(after.distance - before.distance, 5.0, 0.3);
  EXPECT_TRUE(near(after.position, Eigen::Vector2d(5.0, 5.0), 0.3));
}

}  // namespace
}  // namespace lidar_mapping::simulation
