// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/voxel_means.hpp"

#include <cmath>

namespace lidar_mapping::loop_closing {

namespace {

// m. Chosen so that with all permitted leaf sizes the cells fit into a key.
constexpr float kMaxCoordinate = 5e4F;

}  // namespace

void VoxelMeans::reset(double leaf) {
  leaf_ = static_cast<float>(leaf);
  inverse_leaf_ = leaf > 0.0 ? static_cast<float>(1.0 / leaf) : 0.0F;
  pending_count_ = 0;
  voxels_.clear();
  kept_.clear();
}

void VoxelMeans::process_pending() {
  for (std::size_t i = 0; i < pending_count_; ++i) {
    Voxel& voxel = voxels_.find_or_add(pending_[i].key);
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
    kept_.push_back(p);
    return;
  }
  const VoxelIndex cell = voxel_index(p * inverse_leaf_);
  PendingPoint& pending_point = pending_[pending_count_++];
  pending_point.key = voxel_key(cell);
  pending_point.offset = p - leaf_ * cell.cast<float>();
  if (pending_count_ == kMaxPending) process_pending();
}

std::vector<Eigen::Vector3f> VoxelMeans::points() {
  if (leaf_ <= 0.0F) return kept_;
  process_pending();
  std::vector<Eigen::Vector3f> result;
  result.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_.elements()) {
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
