// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/voxel_means.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::uint32_t kEmptySlot = 0xFFFFFFFFU;  // chosen: no index, as there are fewer voxels
constexpr std::size_t kMinSlots = 1 << 14;         // 64 kB; chosen, it doubles when needed
// m. Chosen so that with all permitted leaf sizes the cells fit into a key.
constexpr float kMaxCoordinate = 5e4F;

}  // namespace

VoxelMeans::VoxelMeans() : slots_(kMinSlots, kEmptySlot) {}

void VoxelMeans::reset(double leaf) {
  leaf_ = static_cast<float>(leaf);
  inverse_leaf_ = leaf > 0.0 ? static_cast<float>(1.0 / leaf) : 0.0F;
  pending_count_ = 0;
  voxels_.clear();
  std::fill(slots_.begin(), slots_.end(), kEmptySlot);
}

/// The slot with the number of the cell's voxel, or the empty slot for it.
inline std::uint32_t& VoxelMeans::slot_of(VoxelKey key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = VoxelKeyHash()(key) & mask;
  while (slots_[slot] != kEmptySlot && voxels_[slots_[slot]].key != key) slot = (slot + 1) & mask;
  return slots_[slot];
}

void VoxelMeans::grow() {
  slots_.assign(2 * slots_.size(), kEmptySlot);
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) slot_of(voxels_[i].key) = i;
}

inline std::uint32_t VoxelMeans::find_or_add(VoxelKey key) {
  std::uint32_t& slot = slot_of(key);
  if (slot != kEmptySlot) return slot;
  const auto added = static_cast<std::uint32_t>(voxels_.size());
  slot = added;
  voxels_.push_back({key, 0.0F, Eigen::Vector3f::Zero()});
  if (2 * voxels_.size() > slots_.size()) grow();
  return added;
}

void VoxelMeans::process_pending() {
  for (std::size_t i = 0; i < pending_count_; ++i) {
    Voxel& voxel = voxels_[find_or_add(pending_[i].key)];
    voxel.sum += pending_[i].offset;
    voxel.count += 1.0F;
  }
  pending_count_ = 0;
}

void VoxelMeans::add(const Eigen::Vector3f& p) {
  if (!(std::abs(p.x()) < kMaxCoordinate && std::abs(p.y()) < kMaxCoordinate &&
        std::abs(p.z()) < kMaxCoordinate)) {
    return;
  }
  if (leaf_ <= 0.0F) {
    voxels_.push_back({0, 1.0F, p});
    return;
  }
  const VoxelIndex cell = voxel_index(p * inverse_leaf_);
  PendingPoint& pending_point = pending_[pending_count_++];
  pending_point.key = voxel_key(cell);
  pending_point.offset = p - leaf_ * cell.cast<float>();
  if (pending_count_ == kMaxPending) process_pending();
}

std::vector<Eigen::Vector3f> VoxelMeans::points() {
  process_pending();
  std::vector<Eigen::Vector3f> result;
  result.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_) {
    result.emplace_back(leaf_ * voxel_index(voxel.key).cast<float>() + voxel.sum / voxel.count);
  }
  return result;
}

std::vector<Eigen::Vector3f> VoxelMeans::filtered(const PointCloud& cloud, double leaf) {
  reset(leaf);
  for (const Point& point : cloud.points) add(point.position());
  return points();
}

}  // namespace lidar_mapping::loop_closing
