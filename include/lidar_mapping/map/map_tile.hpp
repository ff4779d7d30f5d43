// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

/// Index of a square of the x-y plane of the map, counted in tiles from the origin of the map.
struct TileIndex {
  std::int64_t x = 0;  ///< Number of tiles along x; its lower border is x times the tile size.
  std::int64_t y = 0;  ///< Number of tiles along y.
  /// Order by x, then y.
  bool operator<(const TileIndex& other) const {
    return std::tie(x, y) < std::tie(other.x, other.y);
  }
  /// Whether both are the same tile.
  bool operator==(const TileIndex& other) const { return x == other.x && y == other.y; }
};

/// Points of the map in one square. They are relative to the corner of the square, so that floats
/// keep their precision far away from the origin of the map.
struct MapTile {
  TileIndex index;  ///< Which square it is.
  /// Lower corner of the square in the map frame, m; z is 0.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  PointCloud cloud;  ///< Points relative to `origin`, m.
  /// For each point the key frame that observed its voxel first; empty if unknown.
  std::vector<KeyFrameIndex> key_frames = {};
};

/// Receives one tile after the other.
using TileSink = std::function<void(const MapTile&)>;
/// Passes all tiles of a map to a sink, such as build_tiles() with its arguments.
using TileSource = std::function<void(const TileSink&)>;

}  // namespace lidar_mapping::map
