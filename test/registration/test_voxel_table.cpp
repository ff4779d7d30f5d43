// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/registration/voxel_table.hpp"

namespace lidar_mapping::registration {
namespace {

const auto kNone = [](VoxelKey) { return false; };

bool holds(const VoxelTable& table, VoxelKey key) {
  return table.find(table.slot_of(key)) != nullptr;
}

/// Adds a voxel with this number of points.
void add(VoxelTable& table, VoxelKey key, std::uint16_t count) {
  VoxelSums* const voxel = table.find_or_add(table.slot_of(key));
  ASSERT_NE(voxel, nullptr);
  voxel->count = count;
}

/// Twice around, because a voxel that is deleted costs a step.
template <typename Predicate>
void sweep_all(VoxelTable& table, const Predicate& is_obsolete) {
  for (int i = 0; i < 2; ++i) table.sweep(1.0, is_obsolete);
}

std::size_t used_slots(const VoxelTable& table) {
  return static_cast<std::size_t>(
      std::count_if(table.slots().begin(), table.slots().end(), [](const VoxelSums& voxel) {
        return voxel.key != 0 || voxel.count != 0 || voxel.count_at_plane != 0;
      }));
}

TEST(VoxelTable, HasAPowerOfTwoOfSlots) {
  EXPECT_EQ(VoxelTable(1).slots().size(), 16U);
  EXPECT_EQ(VoxelTable(16).slots().size(), 16U);
  EXPECT_EQ(VoxelTable(17).slots().size(), 32U);
  EXPECT_EQ(VoxelTable(1000).slots().size(), 1024U);
}

TEST(VoxelTable, FindsWhatWasAddedAndNothingElse) {
  VoxelTable table(64);
  for (VoxelKey key = 1; key <= 40; ++key) add(table, 1000 * key, static_cast<std::uint16_t>(key));
  EXPECT_EQ(table.size(), 40U);
  for (VoxelKey key = 1; key <= 40; ++key) {
    const VoxelSums* const voxel = table.find(table.slot_of(1000 * key));
    ASSERT_NE(voxel, nullptr) << key;
    EXPECT_EQ(voxel->key, 1000 * key);
    EXPECT_EQ(voxel->count, key);
    EXPECT_FALSE(holds(table, 1000 * key + 1));
  }
}

TEST(VoxelTable, GivesTheSameVoxelForAKeyThatItHas) {
  VoxelTable table(64);
  add(table, 7, 3);
  EXPECT_EQ(table.find_or_add(table.slot_of(7))->count, 3);
  EXPECT_EQ(table.size(), 1U);
}

TEST(VoxelTable, RefusesNewVoxelsWhenThreeQuartersAreUsed) {
  VoxelTable table(16);
  for (VoxelKey key = 1; key <= 12; ++key) add(table, key, 1);
  EXPECT_EQ(table.find_or_add(table.slot_of(13)), nullptr);
  EXPECT_EQ(table.size(), 12U);
  EXPECT_NE(table.find_or_add(table.slot_of(5)), nullptr) << "it is there already";
  sweep_all(table, [](VoxelKey key) { return key == 5; });
  EXPECT_NE(table.find_or_add(table.slot_of(13)), nullptr) << "there is room again";
}

TEST(VoxelTable, SweepsEachPartInTurn) {
  VoxelTable table(256);
  for (VoxelKey key = 1; key <= 150; ++key) add(table, key, 1);
  std::map<VoxelKey, int> visits;
  const auto count = [&](VoxelKey key) {
    ++visits[key];
    return false;
  };
  table.sweep(0.25, count);
  EXPECT_LT(visits.size(), 150U);
  for (int i = 0; i < 3; ++i) table.sweep(0.25, count);
  EXPECT_EQ(visits.size(), 150U);
  for (const auto& [key, times] : visits) EXPECT_EQ(times, 1) << key;
}

// Long runs of voxels, which wrap around the end of the table, are closed when one of them goes.
TEST(VoxelTable, KeepsTheOthersWhenVoxelsAreRemoved) {
  std::mt19937_64 engine(5);
  VoxelTable table(64);
  std::map<VoxelKey, std::uint16_t> expected;
  for (int round = 0; round < 200; ++round) {
    while (expected.size() < 48) {
      const VoxelKey key = 1 + engine() % 5000;
      const auto count = static_cast<std::uint16_t>(1 + engine() % 1000);
      if (expected.emplace(key, count).second) add(table, key, count);
    }
    const VoxelKey rest = engine() % 3;
    const auto is_obsolete = [&](VoxelKey key) { return key % 3 == rest; };
    sweep_all(table, is_obsolete);
    for (auto it = expected.begin(); it != expected.end();) {
      it = is_obsolete(it->first) ? expected.erase(it) : std::next(it);
    }
    ASSERT_EQ(table.size(), expected.size()) << round;
    ASSERT_EQ(used_slots(table), expected.size()) << round;
    for (const auto& [key, count] : expected) {
      const VoxelSums* const voxel = table.find(table.slot_of(key));
      ASSERT_NE(voxel, nullptr) << round;
      ASSERT_EQ(voxel->count, count) << round;
    }
  }
}

TEST(VoxelTable, RemovesInOnePassAllThatFulfilACondition) {
  std::mt19937_64 engine(7);
  for (int round = 0; round < 200; ++round) {
    VoxelTable table(64);
    std::map<VoxelKey, std::uint16_t> expected;
    while (expected.size() < 48) {
      const VoxelKey key = 1 + engine() % 5000;
      const auto count = static_cast<std::uint16_t>(1 + engine() % 1000);
      if (expected.emplace(key, count).second) add(table, key, count);
    }
    table.remove_if([](VoxelKey key) { return key % 3 != 0; });
    std::size_t kept = 0;
    for (const auto& [key, count] : expected) {
      const VoxelSums* const voxel = table.find(table.slot_of(key));
      ASSERT_EQ(voxel != nullptr, key % 3 == 0) << round;
      if (voxel == nullptr) continue;
      ASSERT_EQ(voxel->count, count) << round;
      ++kept;
    }
    ASSERT_EQ(table.size(), kept) << round;
    ASSERT_EQ(used_slots(table), kept) << round;
  }
}

TEST(VoxelTable, GrowsWithoutAChangeOfItsVoxels) {
  VoxelTable table(16);
  EXPECT_EQ(table.capacity(), 12U);
  for (VoxelKey key = 1; key <= 12; ++key) add(table, 1000 * key, static_cast<std::uint16_t>(key));
  EXPECT_EQ(table.find_or_add(table.slot_of(1)), nullptr);
  table.grow();
  EXPECT_EQ(table.slots().size(), 32U);
  EXPECT_EQ(table.capacity(), 24U);
  EXPECT_EQ(table.size(), 12U);
  for (VoxelKey key = 1; key <= 12; ++key) {
    const VoxelSums* const voxel = table.find(table.slot_of(1000 * key));
    ASSERT_NE(voxel, nullptr) << key;
    EXPECT_EQ(voxel->count, key);
  }
  EXPECT_NE(table.find_or_add(table.slot_of(1)), nullptr) << "there is room again";
}

// With few voxels only these are cleared, with many the whole table.
TEST(VoxelTable, IsEmptyAfterItWasCleared) {
  for (const VoxelKey voxels : {0U, 1U, 15U, 16U, 17U, 48U}) {
    VoxelTable table(64);
    for (VoxelKey key = 1; key <= voxels; ++key) add(table, key, 9);
    table.clear();
    EXPECT_EQ(table.size(), 0U) << voxels;
    EXPECT_EQ(used_slots(table), 0U) << voxels;
    add(table, 3, 2);
    EXPECT_EQ(table.find(table.slot_of(3))->count, 2) << voxels;
  }
}

// A voxel that was moved into the gap of another one is cleared, too.
TEST(VoxelTable, IsEmptyAfterRemovingAndClearing) {
  std::mt19937_64 engine(6);
  VoxelTable table(64);
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < 6; ++i) add(table, 1 + engine() % 300, 4);
    table.sweep(1.0, [](VoxelKey key) { return key % 2 == 0; });
    for (int i = 0; i < 6; ++i) add(table, 1 + engine() % 300, 4);
    table.clear();
    ASSERT_EQ(used_slots(table), 0U) << round;
  }
}

TEST(VoxelTable, BeginsItsSweepAnewAfterItWasCleared) {
  VoxelTable table(64), other(64);
  table.sweep(0.4, kNone);
  table.clear();
  std::vector<VoxelKey> of_table, of_other;
  for (VoxelKey key = 1; key <= 40; ++key) {
    add(table, key, 1);
    add(other, key, 1);
  }
  const auto seen_in = [](std::vector<VoxelKey>& keys) {
    return [&keys](VoxelKey key) {
      keys.push_back(key);
      return false;
    };
  };
  table.sweep(0.5, seen_in(of_table));
  other.sweep(0.5, seen_in(of_other));
  EXPECT_EQ(of_table, of_other);
}

}  // namespace
}  // namespace lidar_mapping::registration
