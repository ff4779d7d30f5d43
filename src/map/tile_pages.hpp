// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>

#include "lidar_mapping/common/nameless_file.hpp"

#include "voxel_tile.hpp"

namespace lidar_mapping::map {

/// Tiles that wait on the disk, in a nameless file in a folder; the file is made with the first
/// tile. Throws FileError.
class TilePages {
 public:
  explicit TilePages(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Whether it was ever put.
  bool contains(const TileIndex& index) const { return pages_.count(index) > 0; }
  void put(const TileIndex& index, const VoxelTile& tile);
  /// The tile as it was put; its place in the file is kept for the next time.
  VoxelTile get(const TileIndex& index) const;

 private:
  struct Page {
    std::uint64_t offset = 0;
    std::size_t room = 0;    ///< voxels
    std::size_t voxels = 0;  ///< voxels
  };

  std::filesystem::path directory_;
  std::unique_ptr<NamelessFile> file_;
  std::uint64_t end_ = 0;
  std::map<TileIndex, Page> pages_;
};

}  // namespace lidar_mapping::map
