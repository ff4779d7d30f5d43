// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "point_tiles.hpp"

namespace lidar_mapping::test {

/// Points of rectangles, a fifth of a metre apart: a map with nothing else in it.
class MadeMap {
 public:
  /// A rectangle from a corner along two edges, m.
  void add_rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& along,
                     const Eigen::Vector3d& across) {
    const auto rows = static_cast<int>(along.norm() / kStep);
    const auto columns = static_cast<int>(across.norm() / kStep);
    for (int i = 0; i <= rows; ++i) {
      for (int k = 0; k <= columns; ++k) {
        const Eigen::Vector3d p = corner + along * (static_cast<double>(i) / rows) +
                                  across * (static_cast<double>(k) / columns);
        points.push_back({p, 0.5F});
      }
    }
  }

  /// All points in one tile, which begins at the origin.
  map_import::PointTilePtr tile() const {
    auto tile = std::make_shared<map_import::PointTile>();
    for (const map_import::MapPoint& point : points) {
      const Eigen::Vector3f p = point.p_map.cast<float>();
      tile->cloud.points.push_back({p.x(), p.y(), p.z(), point.intensity});
    }
    return tile;
  }

  PointCloud cloud() const { return tile()->cloud; }

  static constexpr double kStep = 0.2;  ///< m; chosen: the resolution of imported maps
  std::vector<map_import::MapPoint> points;
};

}  // namespace lidar_mapping::test
