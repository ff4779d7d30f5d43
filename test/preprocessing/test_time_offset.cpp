// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "motion/time_offset.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using Signal = std::function<double(double seconds)>;

/// Samples of a signal over ten seconds, whose stamps are late by `delay`.
std::vector<TimedValue> sampled(const Signal& signal, double rate, double delay = 0.0) {
  std::vector<TimedValue> values;
  for (int i = 0; i < static_cast<int>(10.0 * rate); ++i) {
    const double seconds = i / rate;
    values.push_back({from_seconds(seconds + delay), signal(seconds)});
  }
  return values;
}

double ramp(double seconds) { return 5.0 + 2.0 * seconds; }
double turns(double seconds) { return std::sin(1.5 * seconds); }

TEST(TimeOffset, OfARampIsExact) {
  for (const double delay : {-0.08, 0.0, 0.03}) {
    const auto found = time_offset(sampled(ramp, 100.0), sampled(ramp, 50.0, delay));
    ASSERT_TRUE(found) << delay;
    EXPECT_NEAR(found->seconds, delay, 1e-6) << delay;
    EXPECT_NEAR(found->sigma, 0.0, 1e-6) << delay;
  }
}

TEST(TimeOffset, OfTurnsIsGoodToAMillisecond) {
  const auto found = time_offset(sampled(turns, 100.0), sampled(turns, 100.0, 0.05));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->seconds, 0.05, 0.001);
}

TEST(TimeOffset, DoesNotDependOnTheRates) {
  const auto found = time_offset(sampled(turns, 10.0), sampled(turns, 200.0, 0.05));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->seconds, 0.05, 0.002);
}

// Of least squares: the noise divided by the root of the sum of squared slopes.
TEST(TimeOffset, HasTheUncertaintyOfItsNoise) {
  std::mt19937 engine(4);
  std::normal_distribution<double> noise(0.0, 0.1);
  std::vector<TimedValue> late = sampled(ramp, 100.0, 0.03);
  for (TimedValue& sample : late) sample.value += noise(engine);
  const auto found = time_offset(sampled(ramp, 100.0), late);
  ASSERT_TRUE(found);
  const double expected = 0.1 / std::sqrt(980.0 * 4.0);
  EXPECT_NEAR(found->sigma, expected, 0.1 * expected);
  EXPECT_NEAR(found->seconds, 0.03, 4.0 * expected);
}

TEST(TimeOffset, IsUnknownIfTheSignalDoesNotChange) {
  const auto constant = [](double /*seconds*/) { return 3.0; };
  EXPECT_FALSE(time_offset(sampled(constant, 100.0), sampled(constant, 100.0)));
}

TEST(TimeOffset, NeedsAHundredValuesWithAReferenceAroundThem) {
  std::vector<TimedValue> late = sampled(ramp, 10.0);
  EXPECT_FALSE(time_offset(sampled(ramp, 100.0), late)) << "the outermost ones have none";
  EXPECT_TRUE(time_offset(sampled(ramp, 100.0), sampled(ramp, 11.0)));
  EXPECT_FALSE(time_offset(sampled(ramp, 3.0), sampled(ramp, 100.0)))
      << "gaps of a third of a second";
  EXPECT_FALSE(time_offset({}, late));
  EXPECT_FALSE(time_offset(sampled(ramp, 100.0), {}));
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
