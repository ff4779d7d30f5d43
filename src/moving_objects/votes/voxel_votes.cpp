// SPDX-License-Identifier: BSD-3-Clause
#include "votes/voxel_votes.hpp"

#include <unordered_set>

namespace lidar_mapping::moving_objects {

namespace {

// m, edge of a voxel for blocks of 3x3x3. Chosen: a block of 1.2 m is a part of a car or of a wall
// and has points of several rings.
constexpr float kBlockVoxel = 0.4F;
// m, edge of a voxel for neighbours, which lie in 3x3x3. Chosen: neighbouring
// points of a ring on a surface lie nearer to each other up to 40 m (0.2 degrees: 0.14 m), drops
// and flakes do not.
constexpr float kSmallVoxel = 0.2F;
// Fraction of the voters that have to vote moving in a block. Chosen: a block may be a piece of a
// wall (doc/map.md), so most of its points have to agree.
constexpr double kBlockFraction = 0.7;

}  // namespace

VoxelKeys::VoxelKeys(const TransformedPoints& points, float voxel)
    : points_(points), scale_(1.0F / voxel), columns_(points.size()) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns_[i] = column(floor_to_int(points.x[i] * scale_), floor_to_int(points.y[i] * scale_));
  }
}

void ColumnFilter::add_around(VoxelKey key, int max_distance) {
  const VoxelKey first =
      key - static_cast<VoxelKey>(max_distance) * (kVoxelKeyStepX + kVoxelKeyStepY);
  for (int dx = 0; dx <= 2 * max_distance; ++dx) {
    for (int dy = 0; dy <= 2 * max_distance; ++dy) {
      occupied_.set(VoxelKeys::column_of_key(first + static_cast<VoxelKey>(dx) * kVoxelKeyStepX +
                                             static_cast<VoxelKey>(dy) * kVoxelKeyStepY));
    }
  }
}

NeighbourCounter::NeighbourCounter(const TransformedPoints& points, const std::vector<Vote>& votes)
    : keys_(points, kSmallVoxel) {
  ColumnFilter near;
  bool is_empty = true;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (votes[i] != Vote::kMoving) continue;
    near.add_around(keys_.of(i), 1);
    is_empty = false;
  }
  if (is_empty) return;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (near.may_contain(keys_.column_of(i))) ++counts_[keys_.of(i)];
  }
}

int NeighbourCounter::around(std::size_t candidate) const {
  int sum = 0;
  for_voxels_around(keys_.of(candidate), [&](VoxelKey near) {
    const auto count = counts_.find(near);
    if (count != counts_.end()) sum += count->second;
  });
  return sum;
}

VoteBlocks::VoteBlocks(const TransformedPoints& points, const std::vector<Vote>& votes)
    : keys_(points, kBlockVoxel) {
  std::unordered_set<VoxelKey, VoxelKeyHash> candidates;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (votes[i] == Vote::kMoving) candidates.insert(keys_.of(i));
  }
  for (const VoxelKey key : candidates) {
    near_.add_around(key, 2);
    for_voxels_around(key, [&](VoxelKey block) { blocks_.try_emplace(block); });
  }
  for (const auto& [key, voxel] : counted_voxels(votes)) {
    const VoteCount& vote_count = voxel;
    for_voxels_around(key, [&](VoxelKey near) {
      const auto block = blocks_.find(near);
      if (block != blocks_.end()) block->second.add(vote_count);
    });
  }
}

bool VoteBlocks::is_moving(VoxelKey key) const {
  const auto block = blocks_.find(key);
  return block != blocks_.end() && block->second.is_moving(kBlockFraction);
}

VoteBlocks::Counts VoteBlocks::counted_voxels(const std::vector<Vote>& votes) const {
  Counts voxels;
  if (blocks_.empty()) return voxels;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (votes[i] == Vote::kUnseen || !near_.may_contain(keys_.column_of(i))) continue;
    voxels[keys_.of(i)].add(vote_count_of(votes[i]));
  }
  return voxels;
}

}  // namespace lidar_mapping::moving_objects
