// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>

#include "lidar_mapping/common/nameless_file.hpp"

#include "tiles/voxel_tile.hpp"

namespace lidar_mapping::map {

/// Tiles that are stored temporarily on the disk, in an unnamed file in a folder. The file is
/// created with the first tile. Throws FileError.
class TilePages {
 public:
  explicit TilePages(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Whether the tile was ever stored.
  bool contains(const TileIndex& index) const { return pages_.count(index) > 0; }
  /// Stores a tile; it replaces an older version.
  void put(const TileIndex& index, const VoxelTile& tile);
  /// Reads a stored tile; its space in the file is kept for the next version.
  VoxelTile get(const TileIndex& index) const;

 private:
  struct Page {
    std::uint64_t offset = 0;
    std::size_t capacity = 0;  ///< Voxels that fit in.
    std::size_t voxels = 0;    ///< Voxels that are stored.
  };

  std::filesystem::path directory_;
  std::unique_ptr<NamelessFile> file_;
  std::uint64_t end_ = 0;
  std::map<TileIndex, Page> pages_;
};

}  // namespace lidar_mapping::map
