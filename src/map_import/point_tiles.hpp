// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/common/list_file.hpp"
#include "lidar_mapping/common/lru_cache.hpp"
#include "lidar_mapping/common/point_cloud.hpp"

#include "map_input.hpp"

namespace lidar_mapping::map_import {

/// Number of a square of the map along x and y.
struct PointTileIndex {
  std::int64_t column = 0;
  std::int64_t row = 0;

  bool operator<(const PointTileIndex& other) const {
    return std::tie(column, row) < std::tie(other.column, other.row);
  }
};

/// The points of a square of the map.
struct PointTile {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< in the map, m; the points count from there
  PointCloud cloud;
};
using PointTilePtr = std::shared_ptr<const PointTile>;

/// The points of a whole map, thinned, square by square. They wait in files without a name in a
/// folder; a cache of bounded size holds the squares used last. One thread uses it. Throws
/// FileError.
class PointTiles {
 public:
  /// Edge of a square, m. Chosen: some forty of them reach as far as a LiDAR sees, and one of a
  /// dense map fits into memory.
  static constexpr int kEdge = 40;

  /// Default limit of the cache, points: 128 MB. Chosen: the squares around a place, of a dense map
  /// as well.
  static constexpr std::size_t kMostCached = 8'000'000;

  /// `resolution`: edge of the voxels by which the map is thinned, m.
  PointTiles(std::filesystem::path directory, double resolution,
             std::size_t most_cached = kMostCached);

  /// Adds points; not after finish().
  void add(const std::vector<MapPoint>& points);
  /// Thins all squares. Before it there are none.
  void finish();

  /// All squares with points, in the order of their indices.
  std::vector<PointTileIndex> indices() const { return stored_.keys(); }
  /// Those of them that reach into a square around a position: `radius` (m) to each side.
  std::vector<PointTileIndex> indices_around(const Eigen::Vector3d& p_map, double radius) const;
  /// A square of indices().
  PointTilePtr tile(const PointTileIndex& index);

  std::uint64_t points() const { return points_; }    ///< number of points added
  std::uint64_t thinned() const { return thinned_; }  ///< number of points that are left
  /// Number of points that are left and lie outside of a box (m); after finish().
  std::uint64_t points_outside(const Eigen::AlignedBox3d& box);
  /// Box around all points that were added, m.
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

 private:
  struct PendingTile {
    std::vector<Point> buffer;
    std::vector<std::size_t> parts;  ///< in the file
  };
  Eigen::Vector3d origin_of(const PointTileIndex& index) const;
  void store(PendingTile& tile);
  PointCloud collected(const PendingTile& tile) const;

  std::filesystem::path directory_;
  double resolution_;
  double height_ = 0.0;  ///< of the origins of all squares, m
  Eigen::AlignedBox3d bounds_;
  std::uint64_t points_ = 0;
  std::uint64_t thinned_ = 0;
  std::map<PointTileIndex, PendingTile> pending_;
  ListFile<std::size_t, Point> pending_parts_;
  ListFile<PointTileIndex, Point> stored_;
  LruCache<PointTileIndex, PointTilePtr> cache_;
};

}  // namespace lidar_mapping::map_import
