#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// How the map's x-y plane is cut into tiles and these into voxels. The edge of a tile is a whole
/// number of voxels, so tiles put together are the map.
class TileGrid {
 public:
  TileGrid(double resolution, double tile_size);

  struct Cell {
    TileIndex tile;
    std::uint64_t voxel = 0;  ///< key within the tile
  };
  Cell cell_of(const Eigen::Vector3d& p_map) const;
  Eigen::Vector3d origin_of(const TileIndex& tile) const;

 private:
  double resolution_;
  std::int64_t voxels_per_tile_;
};

/// A point on its way into a tile.
struct TilePoint {
  std::uint64_t voxel = 0;
  Point point;  ///< relative to the tile's origin
};

/// Sums over the points of a voxel, relative to the tile's origin.
struct Voxel {
  std::uint64_t key = 0;
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double intensity = 0.0;
  std::uint32_t count = 0;
};

/// Centroid and mean intensity of each occupied voxel of a tile, in the order in which voxels were
/// hit first. Open addressing over a dense list: one cache line per hit.
class VoxelTile {
 public:
  VoxelTile() = default;
  /// A tile that was taken apart into voxels().
  explicit VoxelTile(std::vector<Voxel> voxels);

  /// In their order.
  void insert(const std::vector<TilePoint>& points);
  std::size_t size() const { return voxels_.size(); }
  const std::vector<Voxel>& voxels() const { return voxels_; }
  /// Appends the centroids, moved by `offset`.
  void append_to(PointCloud& cloud, const Eigen::Vector3d& offset) const;

 private:
  void insert(const TilePoint& point);
  void make_slots(std::size_t count);
  std::size_t first_slot_of(std::uint64_t key) const;
  std::size_t slot_of(std::uint64_t key) const;

  std::vector<Voxel> voxels_;
  std::vector<std::uint32_t> slots_;  ///< position in voxels_ plus 1; 0 is free
};

}  // namespace lidar_mapping::map
