// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/tile_pages.hpp"

namespace lidar_mapping::map {

void TilePages::put(const TileIndex& index, const VoxelTile& tile) {
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  const std::vector<Voxel>& voxels = tile.voxels();
  Page& page = pages_[index];
  if (voxels.size() > page.capacity) {
    // A tile usually grows until it is stored again.
    page.capacity = voxels.size() + voxels.size() / 2;
    page.offset = end_;
    end_ += page.capacity * sizeof(Voxel);
  }
  page.voxels = voxels.size();
  file_->write(page.offset, voxels.data(), voxels.size() * sizeof(Voxel));
}

VoxelTile TilePages::get(const TileIndex& index) const {
  const Page& page = pages_.at(index);
  std::vector<Voxel> voxels(page.voxels);
  file_->read(page.offset, voxels.data(), voxels.size() * sizeof(Voxel));
  return VoxelTile(std::move(voxels));
}

}  // namespace lidar_mapping::map
