// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/voxel_table.hpp"

#include <algorithm>
#include <utility>

namespace lidar_mapping::registration {
namespace {

// Fraction of the slots that may be used. With linear probing and a random key, a search for a
// missing key visits (1 + 1 / (1 - load)^2) / 2 slots (Knuth 1998, The Art of Computer Programming
// 3, 6.4): 8.5 here, but 50 at a load of 0.9.
constexpr double kMaxLoad = 0.75;
// Fraction of the slots up to which they are cleared one by one. Chosen: a slot of a list costs a
// cache miss, which the whole table, read in its order, does not have.
constexpr double kListedFraction = 0.25;

std::size_t next_power_of_two(std::size_t value) {
  std::size_t power = 16;
  while (power < value) power *= 2;
  return power;
}

}  // namespace

VoxelTable::VoxelTable(std::size_t capacity) : slots_(next_power_of_two(capacity)) {
  const auto size = static_cast<double>(slots_.size());
  mask_ = static_cast<std::uint32_t>(slots_.size() - 1);
  max_size_ = static_cast<std::size_t>(kMaxLoad * size);
  max_listed_ = static_cast<std::size_t>(kListedFraction * size);
  for (std::size_t slots = slots_.size(); slots > 1; slots /= 2) --hash_shift_;
}

/// A map of one scan is cleared several times at the start of a drive: by its own voxels, not by
/// the whole table.
void VoxelTable::clear() {
  if (used_.size() < max_listed_) {
    for (const std::uint32_t slot : used_) slots_[slot] = VoxelSums{};
  } else {
    std::fill(slots_.begin(), slots_.end(), VoxelSums{});
  }
  used_.clear();
  size_ = 0;
  sweep_slot_ = 0;
}

void VoxelTable::grow() {
  VoxelTable larger(2 * slots_.size());
  for (const VoxelSums& voxel : slots_) {
    if (voxel.key != 0) *larger.find_or_add(larger.slot_of(voxel.key)) = voxel;
  }
  *this = std::move(larger);
}

/// Closes the gap by moving later voxels of the same run back, so that no tombstones are needed.
void VoxelTable::erase(std::uint32_t slot) {
  std::uint32_t gap = slot;
  for (std::uint32_t i = next(gap); slots_[i].key != 0; i = next(i)) {
    const std::uint32_t first = first_slot(slots_[i].key);
    if (((i - first) & mask_) >= ((i - gap) & mask_)) {
      slots_[gap] = slots_[i];
      gap = i;
    }
  }
  slots_[gap] = VoxelSums{};
  --size_;
}

}  // namespace lidar_mapping::registration
