// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping {
namespace {

std::vector<std::size_t> squares(std::size_t count, int threads) {
  std::vector<std::size_t> numbers(count), result(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  parallel_chunks(count, 7, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) result[i] = numbers[i] * numbers[i];
  });
  return result;
}

TEST(ParallelChunks, GivesTheSameForAnyNumberOfThreads) {
  const std::vector<std::size_t> expected = squares(1000, 1);
  EXPECT_EQ(expected[999], 999U * 999U);
  for (int threads : {0, 2, 4}) {
    for (int round = 0; round < 20; ++round) EXPECT_EQ(squares(1000, threads), expected);
  }
}

TEST(ParallelChunks, TakesEveryIndexOnceAndNoneOfNothing) {
  std::atomic<std::size_t> seen{0};
  const auto count = [&](std::size_t begin, std::size_t end) { seen += end - begin; };
  parallel_chunks(0, 7, 2, count);
  EXPECT_EQ(seen, 0U);
  parallel_chunks(50, 7, 2, count);
  EXPECT_EQ(seen, 50U);
}

TEST(ParallelChunks, PassesOnTheErrorOfAChunk) {
  const auto fail = [](std::size_t begin, std::size_t) {
    if (begin >= 70) throw std::runtime_error("no");
  };
  EXPECT_THROW(parallel_chunks(1000, 7, 2, fail), std::runtime_error);
}

}  // namespace
}  // namespace lidar_mapping
