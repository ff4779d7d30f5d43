// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/voxel_tile.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::map {

namespace {

/// Capacity of a grown list. If it doubled as vectors do, half of the memory of the tiles around
/// the vehicle would be unused.
std::size_t grown_capacity(std::size_t size) {
  constexpr std::size_t kFirstVoxels = 512;  // 28 kB; chosen
  return size + size / 8 + kFirstVoxels;
}

}  // namespace

TileGrid::TileGrid(double resolution, double tile_size)
    : resolution_(resolution),
      voxels_per_tile_(
          std::clamp<std::int64_t>(std::llround(tile_size / resolution), 1, (1 << 16) - 1)) {}

TileGrid::WideVoxelIndex TileGrid::voxel_of(const Eigen::Vector3d& p_map) const {
  return {floor_to_int(p_map.x() / resolution_), floor_to_int(p_map.y() / resolution_),
          floor_to_int(p_map.z() / resolution_)};
}

TileGrid::Square TileGrid::square_of(const WideVoxelIndex& voxel) const {
  const TileIndex tile{floor_divided(voxel.x, voxels_per_tile_),
                       floor_divided(voxel.y, voxels_per_tile_)};
  return {tile, origin_of(tile), tile.x * voxels_per_tile_, tile.y * voxels_per_tile_,
          static_cast<std::uint64_t>(voxels_per_tile_)};
}

Eigen::Vector3d TileGrid::origin_of(const TileIndex& tile) const {
  const double edge = static_cast<double>(voxels_per_tile_) * resolution_;
  return {static_cast<double>(tile.x) * edge, static_cast<double>(tile.y) * edge, 0.0};
}

void VoxelTile::insert(const std::vector<TilePoint>& points, KeyFrameIndex key_frame) {
  // Slots and voxels are prefetched while others are processed, because they are rarely in the
  // cache: so many points ahead. Chosen; results do not depend on it.
  constexpr std::size_t kSlotPrefetch = 16;
  constexpr std::size_t kVoxelPrefetch = 8;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i + kSlotPrefetch < points.size()) {
      voxels_.prefetch_slot(points[i + kSlotPrefetch].voxel);
    }
    if (i + kVoxelPrefetch < points.size()) {
      voxels_.prefetch_element(points[i + kVoxelPrefetch].voxel);
    }
    insert(points[i], key_frame);
  }
}

void VoxelTile::insert(const TilePoint& point, KeyFrameIndex key_frame) {
  if (voxels_.size() == voxels_.capacity()) voxels_.reserve(grown_capacity(voxels_.size()));
  Voxel& voxel = voxels_.find_or_add(point.voxel);
  if (voxel.count == 0) voxel.key_frame = key_frame;
  voxel.x += static_cast<double>(point.point.x);
  voxel.y += static_cast<double>(point.point.y);
  voxel.z += static_cast<double>(point.point.z);
  voxel.intensity += static_cast<double>(point.point.intensity);
  ++voxel.count;
}

void VoxelTile::append_to(PointCloud& cloud, const Eigen::Vector3d& offset) const {
  for (const Voxel& voxel : voxels()) {
    const double scale = 1.0 / voxel.count;
    cloud.points.push_back({static_cast<float>(voxel.x * scale + offset.x()),
                            static_cast<float>(voxel.y * scale + offset.y()),
                            static_cast<float>(voxel.z * scale + offset.z()),
                            static_cast<float>(voxel.intensity * scale)});
  }
}

std::vector<KeyFrameIndex> VoxelTile::key_frames() const {
  std::vector<KeyFrameIndex> key_frames;
  key_frames.reserve(voxels_.size());
  for (const Voxel& voxel : voxels()) key_frames.push_back(voxel.key_frame);
  return key_frames;
}

}  // namespace lidar_mapping::map
