// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "../../src/front_end/scan/hash_kernel.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Every tenth point is too near, too far or not finite.
std::vector<float> some_points(std::size_t count) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> uniform(-60.0F, 60.0F);
  std::vector<float> points;
  for (std::size_t i = 0; i < count; ++i) {
    for (int k = 0; k < 4; ++k) points.push_back(uniform(engine));
    if (i % 30 == 0) points[4 * i] = std::numeric_limits<float>::quiet_NaN();
    if (i % 30 == 10) points[4 * i + 1] = 200.0F;
    if (i % 30 == 20) points[4 * i] = points[4 * i + 1] = points[4 * i + 2] = 0.1F;
  }
  return points;
}

std::vector<std::uint32_t> hashes_of(HashKernel kernel, const std::vector<float>& points,
                                     std::size_t stride) {
  const HashRule rule{1.25F, 1.0F, 10000.0F, 15, 1U << 17};
  const std::size_t count = (points.size() / 4 + stride - 1) / stride;
  std::vector<std::uint32_t> hashes(count);
  kernel(points.data(), stride, count, rule, hashes.data());
  return hashes;
}

// Neighbours are loaded side by side, others one by one, and the rest of a block alone.
TEST(HashKernel, GivesTheSameHashForEveryWayOfLoading) {
  const std::vector<float> points = some_points(203);
  const auto all = hashes_of(portable_hash_kernel(), points, 1);
  for (const std::size_t stride : {3U, 7U}) {
    const auto strided = hashes_of(portable_hash_kernel(), points, stride);
    for (std::size_t i = 0; i < strided.size(); ++i) EXPECT_EQ(strided[i], all[i * stride]) << i;
  }
  for (std::size_t i = 0; i < 203; ++i) EXPECT_EQ(all[i] == 1U << 17, i % 10 == 0) << i;
}

TEST(HashKernel, WiderInstructionsGiveTheSameHashes) {
  if (avx2_hash_kernel() == nullptr) GTEST_SKIP() << "no AVX2 here";
  const std::vector<float> points = some_points(203);
  for (const std::size_t stride : {1U, 3U}) {
    EXPECT_EQ(hashes_of(avx2_hash_kernel(), points, stride),
              hashes_of(portable_hash_kernel(), points, stride));
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
