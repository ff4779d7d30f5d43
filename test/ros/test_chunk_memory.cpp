// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/chunk_memory.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Memory = std::shared_ptr<std::uint8_t>;

TEST(ChunkMemory, IsUsedAgainWhenTheLastPointerIsGone) {
  ChunkMemory memory;
  Memory first = memory.take(1000);
  const std::uint8_t* const address = first.get();
  Memory copy = first;
  first.reset();
  const Memory other = memory.take(1000);
  EXPECT_NE(other.get(), address) << "a copy still holds it";
  copy.reset();
  EXPECT_EQ(memory.take(1000).get(), address);
  EXPECT_EQ(memory.take(10).get(), address) << "less than it has";
}

TEST(ChunkMemory, GrowsWhereItIsTooSmall) {
  ChunkMemory memory;
  memory.take(10);
  const Memory large = memory.take(100'000);
  std::memset(large.get(), 7, 100'000);
  EXPECT_EQ(large.get()[99'999], 7);
}

TEST(ChunkMemory, MayBeReleasedLaterAndElsewhere) {
  Memory kept;
  {
    ChunkMemory memory;
    kept = memory.take(100);
    const Memory other = memory.take(100);
    EXPECT_NE(other.get(), kept.get());
  }
  std::memset(kept.get(), 1, 100);
  std::thread([&] { kept.reset(); }).join();
  EXPECT_FALSE(kept);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
