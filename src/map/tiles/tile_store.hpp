// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

#include "tiles/voxel_tile.hpp"

namespace lidar_mapping::map {

/// The cloud of a key frame in base_link with its pose in the map.
struct CloudWithPose {
  KeyFrameIndex key_frame = 0;
  PointCloudPtr cloud;
  Pose T_map_base;
};

/// The tiles of a map. Clouds are added in batches; the result depends on their order alone, not on
/// the size of the batches or the number of threads.
class TileStore {
 public:
  TileStore(double resolution, double tile_size, int threads);

  /// The points of a cloud, sorted into tiles.
  struct PointsByTile {
    KeyFrameIndex key_frame = 0;
    std::map<TileIndex, std::vector<TilePoint>> tiles;
  };

  /// Adds the points that lie in the tiles of `only` (null: all tiles). Returns the indices of the
  /// tiles that each cloud touches.
  std::vector<std::vector<TileIndex>> add(const std::vector<CloudWithPose>& clouds,
                                          const std::set<TileIndex>* only);
  /// First step of add(): sorts the points of each cloud into tiles.
  std::vector<PointsByTile> sort_into_tiles(const std::vector<CloudWithPose>& clouds,
                                            const std::set<TileIndex>* only) const;
  /// Second step of add(): inserts the points into the voxels of their tiles.
  void insert(const std::vector<PointsByTile>& clouds);

  /// Indices of the tiles that a cloud touches.
  std::vector<TileIndex> tiles_of(const CloudWithPose& cloud) const;
  void clear(const std::set<TileIndex>& tiles);
  void clear() { tiles_.clear(); }

  bool contains(const TileIndex& index) const { return tiles_.count(index) > 0; }
  void put(const TileIndex& index, VoxelTile tile) { tiles_[index] = std::move(tile); }
  /// Removes a tile that is in the store, and returns it.
  VoxelTile extract(const TileIndex& index) {
    VoxelTile tile = std::move(tiles_.at(index));
    tiles_.erase(index);
    return tile;
  }
  std::size_t voxels(const TileIndex& index) const { return tiles_.at(index).size(); }

  /// All points in the map frame, in the order of the tiles.
  PointCloud merged_cloud() const;
  MapTile tile(const TileIndex& index) const;

 private:
  PointsByTile points_by_tile(const CloudWithPose& cloud, const std::set<TileIndex>* only) const;

  TileGrid grid_;
  int threads_;
  std::map<TileIndex, VoxelTile> tiles_;
};

}  // namespace lidar_mapping::map
