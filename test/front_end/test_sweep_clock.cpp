// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "lidar_mapping/simulation/random.hpp"

#include "scan/sweep_clock.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kPeriod = 0.1;    // s
constexpr double kSweep = 0.0999;  // s
constexpr int kScans = 200;

struct Times {
  double largest_error = 0.0;  ///< of the time between two sweeps after the first 70, s
  double jitter = 0.0;         ///< as reported at the end, s
  bool is_as_stamped = true;   ///< each time is that between the stamps
};

/// `error` (s) of a scan's stamp; scans for which `is_there` is false are left out. True sweeps
/// begin every 0.1 s.
Times times(
    const std::function<double(int)>& error, double sweep = kSweep,
    const std::function<bool(int)>& is_there = [](int) { return true; }) {
  SweepClock clock;
  Times result;
  int before = 0;
  Stamp stamp_before = 0;
  for (int i = 0; i < kScans; ++i) {
    if (!is_there(i)) continue;
    const Stamp stamp = from_seconds(1000.0 + kPeriod * i + error(i));
    const double seconds = clock.advance(stamp, 0.5 * sweep, sweep);
    if (i > 0) {
      result.is_as_stamped &=
          seconds == to_seconds(stamp - stamp_before) + 0.5 * sweep - 0.5 * sweep;
    }
    if (i > 70) {
      result.largest_error =
          std::max(result.largest_error, std::abs(seconds - kPeriod * (i - before)));
    }
    before = i;
    stamp_before = stamp;
  }
  result.jitter = clock.jitter();
  return result;
}

/// Normally distributed, of this standard deviation, s.
std::function<double(int)> scatter(double sigma) {
  return [sigma](int i) {
    const double error = sigma * simulation::Random(static_cast<std::uint64_t>(i), 3).normal();
    return std::max(-0.045, std::min(0.045, error));
  };
}

TEST(SweepClock, UsesRegularStampsUnchanged) {
  EXPECT_TRUE(times([](int) { return 0.0; }).is_as_stamped);
  EXPECT_TRUE(times(scatter(0.001)).is_as_stamped);
  EXPECT_EQ(times(scatter(0.001)).jitter, 0.0);
}

TEST(SweepClock, CountsTurnsIfStampsScatter) {
  const Times found = times(scatter(0.02));
  EXPECT_LT(found.largest_error, 0.001);
  EXPECT_NEAR(found.jitter, 0.02, 0.005);
}

TEST(SweepClock, CountsTurnsOverMissingScans) {
  const Times found =
      times(scatter(0.015), kSweep, [](int i) { return i % 7 != 3 && (i < 90 || i > 110); });
  EXPECT_LT(found.largest_error, 0.003);
  EXPECT_GT(found.jitter, 0.01);
}

// A stamp that is off by more than half a turn when counting begins, with the 16th sweep, must not
// put two sweeps into one turn: the time between them would be zero.
TEST(SweepClock, CountsOneTurnBetweenAnySweeps) {
  const auto scattered = [](int i) { return i % 3 == 2 ? 0.02 : i % 3 == 0 ? -0.015 : 0.0; };
  const auto last_is_early = [&](int i) { return i == 15 ? -0.06 : scattered(i); };
  const auto previous_is_late = [&](int i) {
    return i == 14 ? 0.06 : i == 15 ? -0.02 : scattered(i);
  };
  for (const std::function<double(int)>& error :
       {std::function<double(int)>(last_is_early), std::function<double(int)>(previous_is_late)}) {
    SweepClock clock;
    for (int i = 0; i < 30; ++i) {
      const Stamp stamp = from_seconds(1000.0 + kPeriod * i + error(i));
      const double seconds = clock.advance(stamp, 0.5 * kSweep, kSweep);
      if (i >= 15) {
        EXPECT_NEAR(seconds, kPeriod, 0.001) << i;
      }
    }
    EXPECT_GT(clock.jitter(), 0.01);
  }
}

// A view of 300 degrees: the sweep is shorter than the turn, which shows in the stamps.
TEST(SweepClock, FindsThePeriodOfShorterSweeps) {
  EXPECT_LT(times(scatter(0.02), 0.083).largest_error, 0.004);
}

// Scans that are taken when somebody asks for them are where their stamps say.
TEST(SweepClock, UsesDriftingStampsUnchanged) {
  for (const double sweep : {kSweep, 0.0}) {
    double wandered = 0.0;
    const Times found = times(
        [&](int i) {
          return wandered += 0.01 * simulation::Random(static_cast<std::uint64_t>(i), 4).normal();
        },
        sweep);
    EXPECT_EQ(found.jitter, 0.0) << sweep;
  }
}

// A log whose scans were stored in bursts. A period as short as the steps within a burst would be
// one of a million to try, of which some fit by chance.
TEST(SweepClock, SearchesNoPeriodInBursts) {
  SweepClock clock;
  const auto begin = std::chrono::steady_clock::now();
  double stamp = 1000.0;
  for (int i = 0; i < kScans; ++i) {
    const double part = simulation::Random(static_cast<std::uint64_t>(i), 5).uniform();
    stamp += i % 5 == 0 ? 0.5 + 0.01 * (part - 0.5) : 1e-5 * (0.5 + part);
    clock.advance(from_seconds(stamp), 0.0, 0.0);
    ASSERT_EQ(clock.jitter(), 0.0) << i;
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(taken.count(), 0.5) << "ten seconds for each scan by a search";
}

TEST(SweepClock, UsesStampsOfNonSpinningSensorsUnchanged) {
  EXPECT_TRUE(times(scatter(0.02), 0.01).is_as_stamped);
}

// A driver that corrects the motion within a sweep may leave out the times of the points.
TEST(SweepClock, CountsTurnsOfSweepsOfUnknownDuration) {
  const Times found = times(scatter(0.02), 0.0);
  EXPECT_LT(found.largest_error, 0.004);
  EXPECT_NEAR(found.jitter, 0.02, 0.005);
  const auto is_there = [](int i) { return i % 7 != 3 && (i < 90 || i > 110); };
  EXPECT_LT(times(scatter(0.015), 0.0, is_there).largest_error, 0.005);
  EXPECT_TRUE(times(scatter(0.001), 0.0).is_as_stamped);
}

}  // namespace
}  // namespace lidar_mapping::front_end
