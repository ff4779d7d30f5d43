// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/keyed_list.hpp"
#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// Division of the x-y plane of the map into tiles, and of the tiles into voxels. The edge of a
/// tile is a whole number of voxels, so that all tiles together are the map.
class TileGrid {
 public:
  TileGrid(double resolution, double tile_size);

  /// Index of a voxel of the whole map.
  struct WideVoxelIndex {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::int64_t z = 0;
  };
  /// The square of a tile. It is kept from point to point, because the next point usually lies in
  /// the same square.
  struct Square {
    bool contains(const WideVoxelIndex& voxel) const {
      return local(voxel.x, first_x) < width && local(voxel.y, first_y) < width;
    }
    /// Key within the tile of a voxel that the square contains.
    std::uint64_t key_of(const WideVoxelIndex& voxel) const {
      const auto height = static_cast<std::uint32_t>(static_cast<std::int32_t>(voxel.z));
      return std::uint64_t{height} << 32U | local(voxel.y, first_y) << 16U |
             local(voxel.x, first_x);
    }
    static std::uint64_t local(std::int64_t value, std::int64_t first) {
      return static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(first);
    }

    TileIndex tile;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< Its lower corner in the map frame, m.
    std::int64_t first_x = 0;                          ///< Its first voxel.
    std::int64_t first_y = 0;
    std::uint64_t width = 0;  ///< Edge in voxels; a default square contains none.
  };

  WideVoxelIndex voxel_of(const Eigen::Vector3d& p_map) const;
  Square square_of(const WideVoxelIndex& voxel) const;
  Eigen::Vector3d origin_of(const TileIndex& tile) const;

 private:
  double resolution_;
  std::int64_t voxels_per_tile_;
};

/// A point to insert into a tile.
struct TilePoint {
  std::uint64_t voxel = 0;
  Point point;  ///< Relative to the origin of the tile, m.
};

/// Sums over the points of a voxel, relative to the tile's origin.
struct Voxel {
  std::uint64_t key = 0;
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double intensity = 0.0;
  std::uint32_t count = 0;
  KeyFrameIndex key_frame = 0;  ///< Of its first point.
};

/// Hash of a voxel's key within a tile.
struct TileVoxelHash {
  std::size_t operator()(std::uint64_t key) const { return fibonacci_hash(key) >> 32U; }
};

/// Centroid and mean intensity of each occupied voxel of a tile, in the order in which the voxels
/// got their first point.
class VoxelTile {
 public:
  VoxelTile() = default;
  /// Restores a tile from its voxels().
  explicit VoxelTile(std::vector<Voxel> voxels) : voxels_(std::move(voxels)) {}

  /// Inserts points of a key frame in their order.
  void insert(const std::vector<TilePoint>& points, KeyFrameIndex key_frame);
  std::size_t size() const { return voxels_.size(); }
  const std::vector<Voxel>& voxels() const { return voxels_.elements(); }
  /// Appends the centroids to `cloud`, translated by `offset` (m).
  void append_to(PointCloud& cloud, const Eigen::Vector3d& offset) const;
  /// The key frame that observed each voxel first, in the order of voxels().
  std::vector<KeyFrameIndex> key_frames() const;

 private:
  void insert(const TilePoint& point, KeyFrameIndex key_frame);

  KeyedList<Voxel, TileVoxelHash> voxels_;
};

}  // namespace lidar_mapping::map
