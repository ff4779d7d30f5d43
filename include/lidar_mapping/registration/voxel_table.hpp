// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::registration {

/// Sums of the points of a voxel, relative to its centre, and the plane that was fitted to them.
/// One cache line.
struct alignas(64) VoxelSums {
  VoxelKey key = 0;                 ///< 0 marks an empty slot
  std::array<float, 3> sum{};       ///< m
  std::array<float, 6> products{};  ///< xx xy xz yy yz zz, m^2
  /// As WeightedPlane; before the first plane: the view of the last point.
  std::array<float, 3> normal{};
  float offset = 0.0F;                ///< as WeightedPlane, relative to the voxel's centre
  std::uint16_t count = 0;            ///< number of points
  std::uint16_t count_at_plane : 15;  ///< number of points when the plane was fitted; 0: no plane
  std::uint16_t has_front : 1;        ///< 1: the normal points to where the plane is seen from

  /// Without points and without a plane.
  VoxelSums() : count_at_plane(0), has_front(0) {}
};

/// Hash table of voxels with linear probing. It grows only by grow(): when it is full, new voxels
/// are refused. Pointers to voxels are valid until one is removed, or until the table grows.
class VoxelTable {
 public:
  /// Where the search for a key starts.
  struct Slot {
    VoxelKey key = 0;         ///< that is searched for
    std::uint32_t first = 0;  ///< index of the first slot that may hold it
  };

  /// A table of at least `capacity` slots, rounded up to a power of two.
  explicit VoxelTable(std::size_t capacity);

  /// Number of voxels.
  std::size_t size() const { return size_; }
  /// Number of voxels for which there is room.
  std::size_t capacity() const { return max_size_; }
  /// All slots, of which those with a key of zero are empty.
  const std::vector<VoxelSums>& slots() const { return slots_; }
  /// Deletes all voxels.
  void clear();
  /// Doubles the number of slots. The voxels stay as they are, bit for bit.
  void grow();

  /// Where the search for `key` starts.
  Slot slot_of(VoxelKey key) const { return {key, first_slot(key)}; }
  /// Asks the processor to fetch the first slot of a key that will be searched for.
  void prefetch(const Slot& slot) const { __builtin_prefetch(&slots_[slot.first]); }
  /// The voxel of that key; null if there is none.
  const VoxelSums* find(const Slot& slot) const {
    for (std::uint32_t i = slot.first; slots_[i].key != 0; i = next(i)) {
      if (slots_[i].key == slot.key) return &slots_[i];
    }
    return nullptr;
  }
  /// The voxel of that key; null if there is none.
  VoxelSums* find(const Slot& slot) {
    return const_cast<VoxelSums*>(static_cast<const VoxelTable*>(this)->find(slot));
  }
  /// The voxel of that key, which is new if there was none; null if the table is full.
  VoxelSums* find_or_add(const Slot& slot) {
    for (std::uint32_t i = slot.first;; i = next(i)) {
      VoxelSums& voxel = slots_[i];
      if (voxel.key == slot.key) return &voxel;
      if (voxel.key != 0) continue;
      if (size_ >= max_size_) return nullptr;
      voxel.key = slot.key;
      if (used_.size() < max_listed_) used_.push_back(i);
      ++size_;
      return &voxel;
    }
  }
  /// Visits the next `fraction` (0 to 1) of the slots and deletes the voxels whose key fulfils
  /// `is_obsolete`. The next call continues where this one ends, as the hand of the clock
  /// algorithm does, so that each call has a bounded cost.
  template <typename Predicate>
  void sweep(double fraction, const Predicate& is_obsolete) {
    const auto steps = static_cast<std::size_t>(fraction * static_cast<double>(slots_.size()));
    for (std::size_t step = 0; step < steps; ++step) {
      const VoxelKey key = slots_[sweep_slot_].key;
      if (key != 0 && is_obsolete(key)) {
        erase(sweep_slot_);  // and stay, because another voxel may have moved into this slot
      } else {
        sweep_slot_ = next(sweep_slot_);
      }
    }
  }
  /// Deletes all voxels whose key fulfils `is_obsolete`, in one pass over all slots.
  template <typename Predicate>
  void remove_if(const Predicate& is_obsolete) {
    for (std::uint32_t slot = 0; slot < slots_.size();) {
      const VoxelKey key = slots_[slot].key;
      if (key != 0 && is_obsolete(key)) {
        erase(slot);  // and stay, as sweep() does
      } else {
        ++slot;
      }
    }
  }

 private:
  std::uint32_t first_slot(VoxelKey key) const {
    return static_cast<std::uint32_t>(fibonacci_hash(key) >> hash_shift_);
  }
  std::uint32_t next(std::uint32_t slot) const { return (slot + 1) & mask_; }
  void erase(std::uint32_t slot);

  std::vector<VoxelSums> slots_;
  /// Slots that have been used since the table was empty, up to max_listed_.
  std::vector<std::uint32_t> used_;
  std::size_t max_listed_ = 0;
  std::size_t max_size_ = 0;
  std::size_t size_ = 0;
  std::uint32_t mask_ = 0;
  std::uint32_t sweep_slot_ = 0;
  int hash_shift_ = 64;
};

}  // namespace lidar_mapping::registration
