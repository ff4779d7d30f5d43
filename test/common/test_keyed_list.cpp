// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/keyed_list.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping {
namespace {

struct Counter {
  VoxelKey key = 0;
  int count = 0;
};
using Counters = KeyedList<Counter, VoxelKeyHash>;

/// All keys begin their search at the same slot.
struct SameHash {
  std::size_t operator()(VoxelKey) const { return 1023; }
};

TEST(KeyedList, FindsWhatItHoldsAndAddsWhatItDoesNotHold) {
  Counters list;
  list.find_or_add(7).count = 1;
  list.find_or_add(0).count = 2;
  ++list.find_or_add(7).count;
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list.elements()[0].key, 7U);
  EXPECT_EQ(list.elements()[0].count, 2);
  EXPECT_EQ(list.elements()[1].key, 0U);
  EXPECT_EQ(list.elements()[1].count, 2);
}

TEST(KeyedList, AgreesWithAMapWhileItGrows) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> coordinate(-40, 40);
  Counters list;
  std::map<VoxelKey, int> counts;
  std::vector<VoxelKey> order;
  for (int i = 0; i < 100000; ++i) {
    const VoxelKey key =
        voxel_key(VoxelIndex(coordinate(random), coordinate(random), coordinate(random)));
    if (++counts[key] == 1) order.push_back(key);
    ++list.find_or_add(key).count;
  }
  ASSERT_EQ(list.size(), order.size());
  ASSERT_GT(list.size(), 50000U);
  for (std::size_t i = 0; i < order.size(); ++i) {
    ASSERT_EQ(list.elements()[i].key, order[i]);
    ASSERT_EQ(list.elements()[i].count, counts[order[i]]);
  }
}

TEST(KeyedList, FindsKeysWhoseSearchesBeginAtTheLastSlot) {
  KeyedList<Counter, SameHash> list;
  for (VoxelKey key = 0; key < 300; ++key) list.find_or_add(key);
  for (VoxelKey key = 0; key < 300; ++key) ++list.find_or_add(key).count;
  ASSERT_EQ(list.size(), 300U);
  for (const Counter& counter : list.elements()) EXPECT_EQ(counter.count, 1);
}

TEST(KeyedList, GoesOnFromAListOfElements) {
  std::vector<Counter> elements;
  for (VoxelKey key = 0; key < 2000; ++key) elements.push_back({3 * key, 1});
  Counters list(elements);
  for (VoxelKey key = 0; key < 3000; ++key) ++list.find_or_add(key).count;
  EXPECT_EQ(list.size(), 4000U);
  EXPECT_EQ(list.elements()[999].count, 2);   // of key 2997
  EXPECT_EQ(list.elements()[1000].count, 1);  // of key 3000, which was not looked for
}

TEST(KeyedList, IsEmptyAfterClear) {
  Counters list(5);
  list.find_or_add(1).count = 9;
  list.clear();
  EXPECT_EQ(list.size(), 0U);
  EXPECT_EQ(list.find_or_add(1).count, 0);
}

TEST(KeyedList, PrefetchesWithoutElements) {
  const Counters list;
  list.prefetch_slot(1);
  list.prefetch_element(1);
  EXPECT_EQ(list.size(), 0U);
}

}  // namespace
}  // namespace lidar_mapping
