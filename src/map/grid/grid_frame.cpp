// SPDX-License-Identifier: BSD-3-Clause
#include "grid/grid_frame.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::map {

void check_raster_size(double columns, double rows, const char* option) {
  constexpr double kMaxPixels = 4e9;  // chosen: 63 km square at 1 m; 16 GB of floats
  if (columns * rows <= kMaxPixels) return;
  throw InputError(
      formatted("a raster of %.0f by %.0f pixels is too large; give a larger %s, or a part of the "
                "map by --crop",
                columns, rows, option));
}

GridFrame::GridFrame(const CloudParts& map, double cell_size) : cell(cell_size) {
  Eigen::AlignedBox2f bounds;
  map.for_each_point([&](const Point& point) { bounds.extend(point.position().head<2>()); });
  if (bounds.isEmpty()) throw InputError("the map has no points; there is no grid to make");
  x_min = cell * std::floor(static_cast<double>(bounds.min().x()) / cell);
  y_min = cell * std::floor(static_cast<double>(bounds.min().y()) / cell);
  check_raster_size((static_cast<double>(bounds.max().x()) - x_min) / cell,
                    (static_cast<double>(bounds.max().y()) - y_min) / cell, "--cell");
  columns = column_of(bounds.max().x()) + 1;
  rows = row_of(bounds.max().y()) + 1;
}

std::string GridFrame::yaml() const {
  return formatted(
      "image: grid.pgm\nresolution: %.9g\norigin: [%.6f, %.6f, 0.0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
      cell, x_min, y_min);
}

}  // namespace lidar_mapping::map
