// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping {
namespace {

TEST(FloorToInt, RoundsDownOnBothSidesOfZero) {
  for (const double value : {-2.0, -1.5, -1e-9, 0.0, 1e-9, 0.99, 1.0, 7.5}) {
    EXPECT_EQ(floor_to_int(value), static_cast<std::int64_t>(std::floor(value))) << value;
    const auto single = static_cast<float>(value);
    EXPECT_EQ(floor_to_int(single), static_cast<int>(std::floor(single))) << value;
  }
}

TEST(FloorDivided, RoundsDownOnBothSidesOfZero) {
  for (const int divisor : {1, 3, 4}) {
    for (int value = -9; value <= 9; ++value) {
      const double quotient = static_cast<double>(value) / divisor;
      EXPECT_EQ(floor_divided(value, divisor), static_cast<int>(std::floor(quotient))) << value;
    }
  }
  const std::int64_t wide = std::int64_t{1} << 40;
  EXPECT_EQ(floor_divided(-wide - 1, wide), -2);
  EXPECT_EQ(floor_divided(wide, wide), 1);
}

TEST(VoxelIndex, IsTheSameInBothPrecisions) {
  const Eigen::Vector3d scaled(-0.25, 3.75, -8.0);
  EXPECT_EQ(voxel_index(scaled), VoxelIndex(-1, 3, -8));
  EXPECT_EQ(voxel_index(scaled.cast<float>()), VoxelIndex(-1, 3, -8));
}

std::vector<VoxelIndex> some_indices() {
  std::mt19937 generator(3);
  std::uniform_int_distribution<int> number(-kVoxelKeyHalf, kVoxelKeyHalf - 1);
  std::vector<VoxelIndex> indices;
  for (int i = 0; i < 500; ++i) {
    indices.emplace_back(number(generator), number(generator), number(generator));
  }
  return indices;
}

TEST(VoxelKey, HoldsTheIndex) {
  for (const VoxelIndex& index : some_indices()) EXPECT_EQ(voxel_index(voxel_key(index)), index);
}

TEST(VoxelKey, LeavesTheUppermostBitFree) {
  EXPECT_EQ(voxel_key(VoxelIndex::Constant(kVoxelKeyHalf - 1)) >> 63U, 0U);
}

TEST(VoxelKey, SortsAsIndicesDo) {
  const auto before = [](const VoxelIndex& a, const VoxelIndex& b) {
    return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
  };
  const std::vector<VoxelIndex> indices = some_indices();
  for (std::size_t i = 1; i < indices.size(); ++i) {
    EXPECT_EQ(voxel_key(indices[i - 1]) < voxel_key(indices[i]),
              before(indices[i - 1], indices[i]));
  }
}

TEST(SquareKey, IsItsOwnForEachSquareAroundZero) {
  std::set<std::uint64_t> keys;
  for (int column = -3; column <= 3; ++column) {
    for (int row = -3; row <= 3; ++row) keys.insert(square_key(column, row));
  }
  EXPECT_EQ(keys.size(), 49U);
  EXPECT_EQ(square_key(1, 0), std::uint64_t{1} << 32U);
  EXPECT_EQ(square_key(0, -1), 0xFFFFFFFFU);
}

TEST(VoxelKey, OfNeighboursComeInTheirOrderAlsoAroundZero) {
  std::vector<VoxelKey> expected;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) expected.push_back(voxel_key({x, y, z}));
    }
  }
  std::vector<VoxelKey> found;
  for_voxels_around(voxel_key({0, 0, 0}), [&](VoxelKey key) { found.push_back(key); });
  EXPECT_EQ(found, expected);
}

/// Neighbours differ in few bits; a table of 4096 slots is to take 1000 of them without crowds.
TEST(VoxelKeyHash, SpreadsNeighbours) {
  std::vector<int> slots(4096, 0);
  for (int x = -5; x < 5; ++x) {
    for (int y = -5; y < 5; ++y) {
      for (int z = -5; z < 5; ++z) ++slots[VoxelKeyHash()(voxel_key({x, y, z})) % slots.size()];
    }
  }
  EXPECT_LE(*std::max_element(slots.begin(), slots.end()), 4);
}

}  // namespace
}  // namespace lidar_mapping
