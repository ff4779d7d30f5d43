// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <tuple>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

/// A square of the map's x-y plane, counted in whole tiles from the origin of the map.
struct TileIndex {
  std::int64_t x = 0;
  std::int64_t y = 0;
  bool operator<(const TileIndex& other) const {
    return std::tie(x, y) < std::tie(other.x, other.y);
  }
  bool operator==(const TileIndex& other) const { return x == other.x && y == other.y; }
};

/// The map's points in one square. Points are relative to `origin`, the square's corner in the map
/// frame, so that they keep their precision far away from the map's origin.
struct MapTile {
  TileIndex index;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  PointCloud cloud;
};

using TileSink = std::function<void(const MapTile&)>;
/// Something that hands all tiles of a map to a sink, such as build_tiles() with its arguments.
using TileSource = std::function<void(const TileSink&)>;

}  // namespace lidar_mapping::map
