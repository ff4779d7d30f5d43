#include "lidar_mapping/loop_closing/voxel_means.hpp"

#include <algorithm>

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::uint32_t kFree = 0xFFFFFFFFU;
constexpr std::size_t kLeastSlots = 1 << 14;
constexpr float kFarthest = 1e5F;  // m; cells of any leaf that the parameters allow fit 32 bits

/// Much faster than std::floor where the processor's own instruction may not be used.
int floor_of(float value) {
  const int whole = static_cast<int>(value);
  return whole - static_cast<int>(value < static_cast<float>(whole));
}

std::uint32_t hash_of(const Eigen::Vector3i& cell) {
  std::uint64_t hash = static_cast<std::uint32_t>(cell.x()) * 0x9E3779B97F4A7C15ULL;
  hash ^= static_cast<std::uint32_t>(cell.y()) * 0xC2B2AE3D27D4EB4FULL;
  hash ^= static_cast<std::uint32_t>(cell.z()) * 0x165667B19E3779F9ULL;
  return static_cast<std::uint32_t>(hash >> 32);
}

}  // namespace

VoxelMeans::VoxelMeans() : slots_(kLeastSlots, kFree) {}

void VoxelMeans::restart(double leaf) {
  leaf_ = static_cast<float>(leaf);
  per_leaf_ = leaf > 0.0 ? static_cast<float>(1.0 / leaf) : 0.0F;
  voxels_.clear();
  std::fill(slots_.begin(), slots_.end(), kFree);
}

/// Where the number of the cell's voxel stands, or has to be put.
inline std::uint32_t& VoxelMeans::slot_of(const Eigen::Vector3i& cell) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash_of(cell) & mask;
  while (slots_[slot] != kFree && voxels_[slots_[slot]].cell != cell) slot = (slot + 1) & mask;
  return slots_[slot];
}

void VoxelMeans::grow() {
  slots_.assign(2 * slots_.size(), kFree);
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) slot_of(voxels_[i].cell) = i;
}

inline std::uint32_t VoxelMeans::find_or_add(const Eigen::Vector3i& cell) {
  std::uint32_t& slot = slot_of(cell);
  if (slot != kFree) return slot;
  const auto added = static_cast<std::uint32_t>(voxels_.size());
  slot = added;
  voxels_.push_back({cell, 0.0F, Eigen::Vector3f::Zero()});
  if (2 * voxels_.size() > slots_.size()) grow();
  return added;
}

void VoxelMeans::add(const Eigen::Vector3f& p) {
  if (!(p.cwiseAbs().maxCoeff() < kFarthest)) return;
  if (leaf_ <= 0.0F) {
    voxels_.push_back({Eigen::Vector3i::Zero(), 1.0F, p});
    return;
  }
  const Eigen::Vector3f scaled = p * per_leaf_;
  const Eigen::Vector3i cell(floor_of(scaled.x()), floor_of(scaled.y()), floor_of(scaled.z()));
  Voxel& voxel = voxels_[find_or_add(cell)];
  voxel.sum += p - leaf_ * cell.cast<float>();
  voxel.count += 1.0F;
}

std::vector<Eigen::Vector3f> VoxelMeans::points() const {
  std::vector<Eigen::Vector3f> result;
  result.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_) {
    result.emplace_back(leaf_ * voxel.cell.cast<float>() + voxel.sum / voxel.count);
  }
  return result;
}

}  // namespace lidar_mapping::loop_closing
