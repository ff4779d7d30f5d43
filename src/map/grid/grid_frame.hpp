// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/map/cloud_parts.hpp"

namespace lidar_mapping::map {

/// Throws InputError for a raster of more than 4e9 pixels, which names the option that sets the
/// size of a pixel.
void check_raster_size(double columns, double rows, const char* option);

/// Geometry of the 2D grid of a map: cells of the x-y plane of the map frame, rows counted from
/// below.
struct GridFrame {
  /// The smallest grid around all points of the map. Throws InputError for a map without points,
  /// and like check_raster_size().
  GridFrame(const CloudParts& map, double cell_size);

  int column_of(float x) const { return static_cast<int>((static_cast<double>(x) - x_min) / cell); }
  int row_of(float y) const { return static_cast<int>((static_cast<double>(y) - y_min) / cell); }
  double x_of(double column) const { return x_min + column * cell; }
  double y_of(double row) const { return y_min + row * cell; }
  /// Text of the YAML file that map_server reads beside the picture.
  std::string yaml() const;

  double cell;  ///< Edge of a cell, m.
  double x_min = 0.0;
  double y_min = 0.0;
  int columns = 0;
  int rows = 0;
};

/// A rectangle of cells of the grid, numbered row by row.
struct GridBlock {
  bool contains(int a_column, int a_row) const {
    return a_column >= column && a_column < column + columns && a_row >= row && a_row < row + rows;
  }
  std::size_t size() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// Index in the block of a cell that it contains.
  std::size_t index_of(int a_column, int a_row) const {
    return static_cast<std::size_t>(a_row - row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(a_column - column);
  }

  int column = 0;  ///< Column of the lower left cell.
  int row = 0;
  int columns = 0;
  int rows = 0;
};

}  // namespace lidar_mapping::map
