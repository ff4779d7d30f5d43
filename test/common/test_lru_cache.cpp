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
  EXPECT_EQ(recent.insert(4, 'd', 100), 'd') << "the newest stays, however heavy";
  EXPECT_EQ(recent.find(1), nullptr);
  recent.clear();
  EXPECT_EQ(recent.find(4), nullptr);
}

}  // namespace
}  // namespace lidar_mapping
