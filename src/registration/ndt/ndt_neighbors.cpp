// SPDX-License-Identifier: BSD-3-Clause
#include "ndt/ndt_neighbors.hpp"

#include <algorithm>

#include "ndt/ndt_kernels.hpp"

namespace lidar_mapping::registration {
namespace {

/// A value that no packed cell has, by the layout of ndt_kernels.hpp: its vertical part would lie
/// outside of the map (kMaxCellZ).
constexpr std::int32_t kNoCell = -1;

Eigen::Vector3i unpacked(std::int32_t packed) {
  const auto bits = static_cast<std::uint32_t>(packed);
  return {static_cast<int>(bits >> 21) - kCellOffsetXY,
          static_cast<int>((bits >> 10) & 0x7FFU) - kCellOffsetXY,
          static_cast<int>(bits & 0x3FFU) - kCellOffsetZ};
}

std::vector<Eigen::Vector3i> offsets_of(NeighborSearch search) {
  std::vector<Eigen::Vector3i> offsets = {Eigen::Vector3i::Zero()};
  if (search == NeighborSearch::kDirect1) return offsets;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int steps = std::abs(x) + std::abs(y) + std::abs(z);
        if (steps == 0 || (search == NeighborSearch::kDirect7 && steps > 1)) continue;
        offsets.emplace_back(x, y, z);
      }
    }
  }
  return offsets;
}

/// True if a radius search of one voxel edge around the point finds the voxel's mean.
bool is_near(const Eigen::Vector3i& cell, const Eigen::Vector3f& point,
             const GaussianVoxelMap& map) {
  const Gaussian gaussian = map.gaussian(cell);
  return gaussian.count > 0 && (gaussian.mean - point.cast<double>()).norm() < map.resolution();
}

}  // namespace

void NdtNeighbors::begin(std::size_t points, NeighborSearch search) {
  if (search != search_ || offsets_.empty()) offsets_ = offsets_of(search);
  search_ = search;
  planes_.resize(offsets_.size());
  for (PlaneArrays& planes : planes_) {
    for (auto* array : {&planes.x, &planes.y, &planes.z, &planes.offset}) array->resize(points);
  }
  cells_.assign(points, kNoCell);
}

void NdtNeighbors::update(const std::vector<std::int32_t>& cells, const RotatedPoints& points,
                          GaussianVoxelMap& map) {
  // Which means are near changes with every motion of a point, which voxel it is in does not.
  const bool all = search_ == NeighborSearch::kKdTree;
  moved_.resize(std::max(moved_.size(), cells.size()));
  std::uint32_t* const moved = moved_.data();
  const std::int32_t* const now = cells.data();
  const std::int32_t* const before = cells_.data();
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    // Without a branch: always write, advance if the point has moved.
    moved[count] = static_cast<std::uint32_t>(i);
    count += static_cast<std::size_t>(all | (now[i] != before[i]));
  }
  moved_count_ = count;
  cells_ = cells;
  for (std::size_t neighbor = 0; neighbor < offsets_.size(); ++neighbor) {
    look_up(neighbor, points, map);
  }
}

void NdtNeighbors::look_up(std::size_t neighbor, const RotatedPoints& points,
                           GaussianVoxelMap& map) {
  // Look-ups between fetching a slot and reading it; chosen, results do not depend on it.
  constexpr std::size_t kAhead = 32;
  const auto cell_at = [&](std::size_t k) -> Eigen::Vector3i {
    return unpacked(cells_[moved_[k]]) + offsets_[neighbor];
  };
  PlaneArrays& planes = planes_[neighbor];
  slots_.resize(std::max(slots_.size(), moved_count_));
  for (std::size_t k = 0; k < moved_count_ + kAhead; ++k) {
    if (k < moved_count_) {
      slots_[k] = map.slot_of(cell_at(k));
      map.prefetch(slots_[k]);
    }
    if (k < kAhead) continue;
    const std::size_t ready = k - kAhead;
    const std::size_t i = moved_[ready];
    WeightedPlane plane = map.plane(cell_at(ready), slots_[ready], points.view(i));
    if (search_ == NeighborSearch::kKdTree && !is_near(cell_at(ready), points.position(i), map)) {
      plane = {};
    }
    planes.x[i] = plane.normal.x();
    planes.y[i] = plane.normal.y();
    planes.z[i] = plane.normal.z();
    planes.offset[i] = plane.offset;
  }
}

}  // namespace lidar_mapping::registration
