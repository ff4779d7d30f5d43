// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/lru_cache.hpp"

namespace lidar_mapping {
namespace {

TEST(LruCache, RemovesTheLeastRecentlyUsedValue) {
  LruCache<int, char> recent(10);
  recent.insert(1, 'a', 4);
  recent.insert(2, 'b', 4);
  ASSERT_NE(recent.find(1), nullptr);
  recent.insert(3, 'c', 4);
  EXPECT_EQ(recent.find(2), nullptr);
  EXPECT_EQ(*recent.find(1), 'a');
  recent.insert(1, 'd', 10);
  EXPECT_EQ(*recent.find(1), 'd');
  EXPECT_EQ(recent.weight(), 10U) << "without the value that it had before";
  recent.clear();
  EXPECT_EQ(recent.find(1), nullptr);
}

}  // namespace
}  // namespace lidar_mapping
