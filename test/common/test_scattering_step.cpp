// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/scattering_step.hpp"

namespace lidar_mapping {
namespace {

/// How often each of `count` things is visited in as many steps.
std::vector<int> visits(std::size_t count) {
  std::vector<int> result(count, 0);
  const std::size_t step = scattering_step(count);
  for (std::size_t i = 0, at = 0; i < count; ++i, at = (at + step) % count) ++result[at];
  return result;
}

TEST(ScatteringStep, LeavesNothingOut) {
  for (std::size_t count = 1; count <= 600; ++count) {
    ASSERT_EQ(visits(count), std::vector<int>(count, 1)) << count;
  }
}

// Of five in a row, those that are three steps apart are nearest: 0.146 by the golden section. The
// numbers are primes, powers of two and numbers with many divisors.
TEST(ScatteringStep, KeepsSuccessiveOnesApart) {
  for (const std::size_t count : {1000U, 1024U, 5040U, 65536U, 99991U, 100000U, 720720U}) {
    const std::size_t step = scattering_step(count);
    for (std::size_t apart = 1; apart <= 4; ++apart) {
      const std::size_t ahead = apart * step % count;
      const auto nearest = static_cast<double>(std::min(ahead, count - ahead));
      EXPECT_GT(nearest / static_cast<double>(count), 0.14) << count << ", " << apart;
    }
  }
}

TEST(ScatteringStep, OfNothingIsNoEndlessSearch) { EXPECT_EQ(scattering_step(0), 1U); }

}  // namespace
}  // namespace lidar_mapping
