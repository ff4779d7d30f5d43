// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

#include "voxel_tile.hpp"

namespace lidar_mapping::map {

/// A cloud and where it lies.
struct PlacedCloud {
  PointCloudPtr cloud;
  Pose T_map_base;
};

/// The tiles of a map. Clouds are added in batches; the result depends on their order alone, not on
/// the size of batches or the number of threads.
class TileStore {
 public:
  TileStore(double resolution, double tile_size, int threads);

  using Sorted = std::map<TileIndex, std::vector<TilePoint>>;

  /// Adds the points that fall into tiles of `only` (null: all). Gives the tiles of each cloud.
  std::vector<std::vector<TileIndex>> add(const std::vector<PlacedCloud>& clouds,
                                          const std::set<TileIndex>* only);
  /// The two steps of add().
  std::vector<Sorted> sorted(const std::vector<PlacedCloud>& clouds,
                             const std::set<TileIndex>* only) const;
  void insert(const std::vector<Sorted>& clouds);

  /// The tiles that a cloud touches.
  std::vector<TileIndex> tiles_of(const PlacedCloud& cloud) const;
  void clear(const std::set<TileIndex>& tiles);
  void clear() { tiles_.clear(); }

  bool contains(const TileIndex& index) const { return tiles_.count(index) > 0; }
  void put(const TileIndex& index, VoxelTile tile) { tiles_[index] = std::move(tile); }
  /// A tile that is there leaves the store.
  VoxelTile take(const TileIndex& index) {
    VoxelTile tile = std::move(tiles_.at(index));
    tiles_.erase(index);
    return tile;
  }
  std::size_t voxels(const TileIndex& index) const { return tiles_.at(index).size(); }

  /// All points in the map frame, tile by tile.
  PointCloud joined() const;
  MapTile tile(const TileIndex& index) const;

 private:
  Sorted sorted_into_tiles(const PlacedCloud& cloud, const std::set<TileIndex>* only) const;

  TileGrid grid_;
  int threads_;
  std::map<TileIndex, VoxelTile> tiles_;
};

}  // namespace lidar_mapping::map
