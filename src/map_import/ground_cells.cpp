// SPDX-License-Identifier: BSD-3-Clause
#include "ground_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::map_import {

namespace {

// m from the lowest to the highest point of a ground. Chosen: a ramp of 20 % across a column, a
// kerb of 0.15 m, and the noise of a map.
constexpr float kThickness = 0.3F;
// m above the lowest point that have to be free. Chosen: cars and persons pass, car parks are
// higher.
constexpr float kHeadroom = 2.0F;
// Points of a ground. Chosen: with one alone, an outlier is ground.
constexpr std::ptrdiff_t kFewest = 2;
// Points in the free space. Chosen: as few as what moved may leave in a thinned map; a pole of 2 m
// has more.
constexpr std::ptrdiff_t kMostInTheWay = 2;
// Of the points of a ground. Chosen: of a thin ceiling and the floor on it, the upper one counts.
constexpr double kUpperSide = 0.75;

constexpr int kCellsPerEdge = PointTiles::kEdge / static_cast<int>(kGroundCell);
using Columns = std::vector<std::vector<float>>;

Columns columns_of(const PointCloud& cloud) {
  Columns columns(static_cast<std::size_t>(kCellsPerEdge * kCellsPerEdge));
  const auto place = [](float along) {
    return std::clamp(static_cast<int>(along / static_cast<float>(kGroundCell)), 0,
                      kCellsPerEdge - 1);
  };
  for (const Point& point : cloud.points) {
    const int number = place(point.x) * kCellsPerEdge + place(point.y);
    columns[number].push_back(point.z);
  }
  return columns;
}

}  // namespace

std::vector<float> ground_heights(std::vector<float> heights) {
  std::sort(heights.begin(), heights.end());
  std::vector<float> grounds;
  for (auto lowest = heights.begin(); lowest != heights.end();) {
    const auto above = std::upper_bound(lowest, heights.end(), *lowest + kThickness);
    const auto free = std::upper_bound(above, heights.end(), *lowest + kHeadroom);
    if (above - lowest < kFewest || free - above > kMostInTheWay) {
      ++lowest;
      continue;
    }
    grounds.push_back(quantile_of_range(lowest, above, kUpperSide));
    lowest = free;
  }
  return grounds;
}

std::vector<GroundCell> ground_cells(PointTiles& tiles) {
  std::vector<GroundCell> cells;
  for (const PointTileIndex& index : tiles.indices()) {
    const PointTilePtr tile = tiles.tile(index);
    const Columns columns = columns_of(tile->cloud);
    for (int i = 0; i < kCellsPerEdge * kCellsPerEdge; ++i) {
      GroundCell cell;
      cell.column = static_cast<int>(index.column) * kCellsPerEdge + i / kCellsPerEdge;
      cell.row = static_cast<int>(index.row) * kCellsPerEdge + i % kCellsPerEdge;
      for (const float height : ground_heights(columns[i])) {
        cell.height = tile->origin.z() + static_cast<double>(height);
        cells.push_back(cell);
      }
    }
  }
  std::sort(cells.begin(), cells.end(), [](const GroundCell& a, const GroundCell& b) {
    return std::tie(a.column, a.row, a.height) < std::tie(b.column, b.row, b.height);
  });
  return cells;
}

}  // namespace lidar_mapping::map_import
